// Streams the samples of an MPU6050 to `footnav capture serial`.  Wiring and troubleshooting: docs/capture.md.

#include <Wire.h>

#include "line.h"

// What you may change.

constexpr uint16_t DEVICE = 1;          // any number that tells this sensor from your others
constexpr uint8_t ADDRESS = 0x68;       // 0x69 with AD0 at VCC
constexpr uint8_t INTERRUPT_PIN = 2;    // where the sensor's INT goes; an Uno or Nano has 2 and 3
constexpr uint8_t ACCEL_RANGE = 3;      // 0 to 3: 2, 4, 8, 16 g
constexpr uint8_t GYRO_RANGE = 3;       // 0 to 3: 250, 500, 1000, 2000 deg/s
constexpr uint8_t DLPF = 2;             // 1 to 6: 188, 98, 42, 20, 10, 5 Hz
constexpr uint8_t RATE_DIVIDER = 4;     // samples per second: 1000 / (1 + RATE_DIVIDER)
constexpr uint32_t BAUD = 250000;       // a whole fraction of 16 MHz and of 8 MHz, unlike 115200

// What follows from it.

static_assert(ACCEL_RANGE <= 3 && GYRO_RANGE <= 3, "ranges are 0 to 3");
static_assert(1 <= DLPF && DLPF <= 6, "DLPF is 1 to 6");

constexpr uint8_t SETTINGS[line::SETTINGS_REGISTERS] = {RATE_DIVIDER, DLPF, GYRO_RANGE << 3, ACCEL_RANGE << 3};

// A byte takes ten bits on the line.  A tenth stays free for the headers.
static_assert(10UL * line::SAMPLE_LENGTH * (1000UL / (1 + RATE_DIVIDER)) <= BAUD / 10 * 9, "raise BAUD or RATE_DIVIDER");

constexpr uint32_t HEADER_INTERVAL_MS = 2000;
constexpr uint32_t SILENCE_MS = 500;
constexpr uint32_t RETRY_MS = 1000;

constexpr uint8_t MPU6050_ID = 0x68;
constexpr uint8_t SMPLRT_DIV = 0x19;
constexpr uint8_t INT_ENABLE = 0x38;
constexpr uint8_t ACCEL_XOUT_H = 0x3B;
constexpr uint8_t PWR_MGMT_1 = 0x6B;
constexpr uint8_t WHO_AM_I = 0x75;

#ifndef IRAM_ATTR  // Where the code of an interrupt lies is a matter of the ESP boards.
#define IRAM_ATTR
#endif

// When the newest sample was ready, and how many there were, taken or not: a number that is missing was lost here.
volatile uint32_t readyAt = 0;
volatile uint16_t readyCount = 0;

struct Ready {
  uint32_t at;
  uint16_t count;
};

void IRAM_ATTR onDataReady() {
  readyAt = micros();
  readyCount = readyCount + 1;
}

Ready latest() {
  noInterrupts();
  const Ready ready = {readyAt, readyCount};
  interrupts();
  return ready;
}

bool writeRegister(uint8_t address, uint8_t value) {
  Wire.beginTransmission(ADDRESS);
  Wire.write(address);
  Wire.write(value);
  return Wire.endTransmission() == 0;
}

bool readRegisters(uint8_t address, uint8_t *values, uint8_t count) {
  Wire.beginTransmission(ADDRESS);
  Wire.write(address);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(ADDRESS, count) != count) return false;
  for (uint8_t k = 0; k < count; ++k) values[k] = uint8_t(Wire.read());
  return true;
}

void sendFault(line::Fault code, uint8_t detail = 0) {
  char text[line::FAULT_LENGTH];
  Serial.write(text, line::fault(text, code, detail));
}

// Sends what the chip is set to, as the chip itself tells: a dip of its supply puts it back to 2 g.
bool sendHeader() {
  uint8_t settings[line::SETTINGS_REGISTERS];
  if (!readRegisters(SMPLRT_DIV, settings, sizeof settings)) {
    sendFault(line::NO_ANSWER);
    return false;
  }
  for (uint8_t k = 0; k < sizeof settings; ++k) {
    if (settings[k] == SETTINGS[k]) continue;
    sendFault(line::SETTINGS_LOST, settings[k]);
    return false;
  }
  char text[line::HEADER_LENGTH];
  Serial.write(text, line::header(text, DEVICE, MPU6050_ID, settings));
  return true;
}

bool isMpu6050() {
  uint8_t chip = 0;
  if (!readRegisters(WHO_AM_I, &chip, 1)) {
    sendFault(line::NO_ANSWER);
    return false;
  }
  if (chip != MPU6050_ID) sendFault(line::OTHER_CHIP, chip);
  return chip == MPU6050_ID;
}

void configure() {
  writeRegister(PWR_MGMT_1, 0x80);  // everything as after power-on
  delay(100);
  writeRegister(PWR_MGMT_1, 0x01);  // awake, on the gyroscope's oscillator
  delay(50);
  for (uint8_t k = 0; k < sizeof SETTINGS; ++k) writeRegister(SMPLRT_DIV + k, SETTINGS[k]);
  writeRegister(INT_ENABLE, 0x01);  // a pulse on INT for every sample
}

bool running = false;
uint16_t sentCount = 0;
uint32_t headerAt = 0;
uint32_t sampleAt = 0;

void start() {
  running = isMpu6050();
  if (running) {
    configure();
    running = sendHeader();
  }
  sentCount = latest().count;
  headerAt = sampleAt = millis();
  if (!running) delay(RETRY_MS);
}

void setup() {
  Serial.begin(BAUD);
  Wire.begin();
  Wire.setClock(400000);
#ifdef WIRE_HAS_TIMEOUT
  Wire.setWireTimeout(25000, true);  // a loose wire must not stop the board
#endif
  pinMode(INTERRUPT_PIN, INPUT);
  attachInterrupt(digitalPinToInterrupt(INTERRUPT_PIN), onDataReady, RISING);
}

void sendSample(const Ready &ready) {
  uint8_t registers[line::SAMPLE_REGISTERS];
  if (!readRegisters(ACCEL_XOUT_H, registers, sizeof registers)) {
    sendFault(line::NO_ANSWER);
    running = false;
    return;
  }
  // When the next sample came meanwhile, nobody knows whose registers these are: the sample counts as lost.
  if (latest().count != ready.count) return;
  char text[line::SAMPLE_LENGTH];
  Serial.write(text, line::sample(text, ready.at, ready.count, registers));
}

void loop() {
  if (!running) {
    start();
    return;
  }
  const Ready ready = latest();
  if (ready.count != sentCount) {
    sentCount = ready.count;
    sampleAt = millis();
    sendSample(ready);
  } else if (millis() - sampleAt > SILENCE_MS) {
    sendFault(line::NO_DATA_READY);
    running = false;
  }
  if (running && millis() - headerAt >= HEADER_INTERVAL_MS) {
    headerAt = millis();
    running = sendHeader();
  }
}
