// What the sketch uses of the Teensy's headers, declared and never defined: enough to compile
// against, nothing to run. Names and types follow Teensyduino's.
#pragma once

#include <stddef.h>
#include <stdint.h>

#define DMAMEM __attribute__((section(".dmabuffers"), used))

enum { LOW = 0, HIGH = 1 };
enum { INPUT = 0, OUTPUT = 1, INPUT_PULLUP = 2 };
enum { A0 = 14, A1, A2, A3, A4, A5 };

void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
uint8_t digitalRead(uint8_t pin);
int analogRead(uint8_t pin);
void analogReadResolution(unsigned int bits);
void analogReadAveraging(unsigned int readings);
void delay(uint32_t milliseconds);

class IntervalTimer {
public:
  bool begin(void (*function)(), float microseconds);
  void update(float microseconds);
};

class usb_serial_class {
public:
  void begin(long);
  int available();
  int read();
  int availableForWrite();
  size_t write(const uint8_t *bytes, size_t n);
  size_t print(const char *text);
  size_t println(uint32_t number);
};
extern usb_serial_class Serial;

void setup();
void loop();
