// Runs the sketch on a simulated board: board CASE FIRST_MICROS SECONDS.
// CASE: sound, absent (no chip), other (another chip), silent (no wire to INT), dip (the supply fails after 1.1 s).
// The n-th sample since the chip was started reads n in each of its seven channels.

#include <cstdlib>
#include <cstring>

#include "Arduino.h"
#include "Wire.h"

#include "mpu6050_stream.ino"

namespace {

constexpr uint64_t DIP_AT = 1100000;
constexpr uint64_t BYTE_TIME = 23;

const char *scenario;
uint64_t now = 0;
uint32_t firstMicros;
void (*handler)() = nullptr;

uint8_t registers[128];
uint64_t nextSample = 0;
uint16_t samples = 0;
uint8_t pointer = 0;
bool addressed = false;
bool dipped = false;

bool is(const char *name) { return strcmp(scenario, name) == 0; }

void resetChip() {
  memset(registers, 0, sizeof registers);
  registers[PWR_MGMT_1] = 0x40;
  registers[WHO_AM_I] = is("other") ? 0x71 : 0x68;
}

void takeSample() {
  ++samples;
  for (int channel = 0; channel < 7; ++channel) {
    registers[ACCEL_XOUT_H + 2 * channel] = uint8_t(samples >> 8);
    registers[ACCEL_XOUT_H + 2 * channel + 1] = uint8_t(samples);
  }
  if ((registers[INT_ENABLE] & 1) && handler && !is("silent")) handler();
}

void pass(uint64_t duration) {
  for (const uint64_t end = now + duration; now < end;) {
    const bool awake = registers[PWR_MGMT_1] == 0x01;
    if (!awake) nextSample = end + 1000 * (1 + registers[SMPLRT_DIV]);
    now = awake && nextSample < end ? nextSample : end;
    if (awake && now == nextSample) {
      takeSample();
      nextSample += 1000 * (1 + registers[SMPLRT_DIV]);
    }
  }
  if (is("dip") && !dipped && now > DIP_AT) {
    dipped = true;
    resetChip();
  }
}

}  // namespace

uint32_t micros() {
  return uint32_t(firstMicros + now);
}

uint32_t millis() {
  pass(1);
  return uint32_t(now / 1000);
}

void delay(uint32_t ms) { pass(1000ULL * ms); }

void attachInterrupt(int, void (*given)(), int) { handler = given; }

TwoWire Wire;

void TwoWire::beginTransmission(uint8_t address) { addressed = address == ADDRESS && !is("absent"), pointer = 0xFF; }

void TwoWire::write(uint8_t value) {
  pass(BYTE_TIME);
  if (pointer == 0xFF) {
    pointer = value;
    return;
  }
  if (!addressed) return;
  if (pointer == PWR_MGMT_1 && value & 0x80) resetChip();
  else registers[pointer++] = value;
}

uint8_t TwoWire::endTransmission(bool) {
  pass(BYTE_TIME);
  return addressed ? 0 : 2;
}

uint8_t TwoWire::requestFrom(uint8_t, uint8_t count) {
  pass(BYTE_TIME);
  return addressed ? count : 0;
}

int TwoWire::read() {
  pass(BYTE_TIME);
  return registers[pointer++];
}

int main(int, char **arguments) {
  scenario = arguments[1];
  firstMicros = uint32_t(strtoul(arguments[2], nullptr, 10));
  const uint64_t end = uint64_t(1e6 * atof(arguments[3]));
  resetChip();
  setup();
  while (now < end) {
    loop();
    pass(10);
  }
}
