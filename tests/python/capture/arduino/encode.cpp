// Writes the lines of the values on standard input: S stamp number 14 registers, H device chip 4 registers, X code detail.

#include <cstdio>

#include "line.h"

static void scan(uint8_t *values, int count) {
  for (int k = 0; k < count; ++k) {
    unsigned value = 0;
    if (scanf("%u", &value) == 1) values[k] = uint8_t(value);
  }
}

int main() {
  char kind = 0, text[64];
  unsigned a = 0, b = 0;
  while (scanf(" %c %u %u", &kind, &a, &b) == 3) {
    uint8_t values[line::SAMPLE_REGISTERS] = {}, length = 0;
    if (kind == 'S') {
      scan(values, line::SAMPLE_REGISTERS);
      length = line::sample(text, a, uint16_t(b), values);
    } else if (kind == 'H') {
      scan(values, line::SETTINGS_REGISTERS);
      length = line::header(text, uint16_t(a), uint8_t(b), values);
    } else {
      length = line::fault(text, line::Fault(a), uint8_t(b));
    }
    fwrite(text, 1, length, stdout);
  }
}
