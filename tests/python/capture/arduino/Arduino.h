// What the sketch needs of an Arduino, with a simulated clock, an MPU6050 on the bus and standard output as the port.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>

constexpr int INPUT = 0, RISING = 3;

uint32_t micros();
uint32_t millis();
void delay(uint32_t ms);
inline void pinMode(int, int) {}
inline int digitalPinToInterrupt(int pin) { return pin; }
void attachInterrupt(int, void (*handler)(), int);
inline void noInterrupts() {}
inline void interrupts() {}

struct SerialPort {
  void begin(uint32_t) {}
  size_t write(const char *text, size_t count) { return fwrite(text, 1, count, stdout); }
};
static SerialPort Serial;
