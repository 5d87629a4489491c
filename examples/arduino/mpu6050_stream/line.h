// The lines that the sketch sends: a letter, big-endian upper-case hexadecimal digits, the CRC-16 of all characters
// before it, a line feed.  docs/capture.md has the table; python/footnav/capture/line.py reads them.
// Nothing in here needs an Arduino, so that a PC can check it.

#pragma once

#include <stdint.h>

namespace line {

constexpr uint8_t PROTOCOL = 1;

// Registers of a sample (accelerometer, thermometer, gyroscope) and of the settings (SMPLRT_DIV to ACCEL_CONFIG).
constexpr uint8_t SAMPLE_REGISTERS = 14;
constexpr uint8_t SETTINGS_REGISTERS = 4;

// Characters of each line, with the line feed.
constexpr uint8_t SAMPLE_LENGTH = 1 + 2 * (4 + 2 + SAMPLE_REGISTERS) + 4 + 1;
constexpr uint8_t HEADER_LENGTH = 1 + 2 * (1 + 2 + 1 + SETTINGS_REGISTERS) + 4 + 1;
constexpr uint8_t FAULT_LENGTH = 1 + 2 * (1 + 1) + 4 + 1;

enum Fault : uint8_t { NO_ANSWER = 1, OTHER_CHIP = 2, NO_DATA_READY = 3, SETTINGS_LOST = 4 };

// CRC-16/IBM-3740: polynomial 0x1021, initial value 0xFFFF, no reflection.  By nibbles, without a table: some
// 0.1 ms for a line at 16 MHz.
inline uint16_t crc16(const char *text, uint8_t length) {
  uint16_t crc = 0xFFFF;
  for (uint8_t k = 0; k < length; ++k) {
    uint8_t x = uint8_t(crc >> 8) ^ uint8_t(text[k]);
    x ^= x >> 4;
    crc = uint16_t(crc << 8) ^ uint16_t(uint16_t(x) << 12) ^ uint16_t(uint16_t(x) << 5) ^ x;
  }
  return crc;
}

// Writes one line into a buffer of at least the line's length.
class Writer {
public:
  Writer(char *buffer, char kind) : begin(buffer), end(buffer) { *end++ = kind; }

  void byte(uint8_t value) {
    *end++ = digit(value >> 4);
    *end++ = digit(value & 15);
  }

  void word(uint16_t value) {
    byte(uint8_t(value >> 8));
    byte(uint8_t(value));
  }

  void bytes(const uint8_t *values, uint8_t count) {
    for (uint8_t k = 0; k < count; ++k) byte(values[k]);
  }

  uint8_t finish() {
    word(crc16(begin, uint8_t(end - begin)));
    *end++ = '\n';
    return uint8_t(end - begin);
  }

private:
  static char digit(uint8_t nibble) { return char(nibble < 10 ? '0' + nibble : 'A' + nibble - 10); }

  char *begin;
  char *end;
};

// The functions return the number of characters.

inline uint8_t sample(char *buffer, uint32_t stamp, uint16_t number, const uint8_t *registers) {
  Writer writer(buffer, 'S');
  writer.word(uint16_t(stamp >> 16));
  writer.word(uint16_t(stamp));
  writer.word(number);
  writer.bytes(registers, SAMPLE_REGISTERS);
  return writer.finish();
}

inline uint8_t header(char *buffer, uint16_t device, uint8_t chip, const uint8_t *settings) {
  Writer writer(buffer, 'H');
  writer.byte(PROTOCOL);
  writer.word(device);
  writer.byte(chip);
  writer.bytes(settings, SETTINGS_REGISTERS);
  return writer.finish();
}

inline uint8_t fault(char *buffer, Fault code, uint8_t detail) {
  Writer writer(buffer, 'X');
  writer.byte(code);
  writer.byte(detail);
  return writer.finish();
}

}  // namespace line
