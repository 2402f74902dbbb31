// Stub of the Teensy's headers: declarations that the sketch uses, without definitions. Names and
// types follow Teensyduino's. ../host simulates them on a PC.
#pragma once

#include <avr/pgmspace.h>
#include <stddef.h>
#include <stdint.h>

enum { LOW = 0, HIGH = 1 };
enum { INPUT = 0, OUTPUT = 1, INPUT_PULLUP = 2, INPUT_DISABLE = 5 };
enum { A0 = 14, A1, A2, A3, A4, A5 };

#if defined(__arm__)
#define ARM_DWT_CYCCNT (*(volatile uint32_t *)0xE0001004)
#else
extern volatile uint32_t ARM_DWT_CYCCNT;
#endif
extern "C" volatile uint32_t F_CPU_ACTUAL;

extern "C" {
void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
uint8_t digitalRead(uint8_t pin);
int analogRead(uint8_t pin);
void analogReadResolution(unsigned int bits);
void analogReadAveraging(unsigned int readings);
void delay(uint32_t milliseconds);
uint32_t micros(void);
}

class IntervalTimer {
public:
  bool begin(void (*function)(), float microseconds);
  void update(float microseconds);
  void end();
};

class Print {
public:
  virtual size_t write(const uint8_t *bytes, size_t n) = 0;
  virtual int availableForWrite() = 0;
  size_t print(const char *text);
  size_t print(int number);
  size_t print(double number, int digits = 2);
  size_t println(const char *text);
  size_t println(uint32_t number);
  size_t println(double number, int digits = 2);
};

class usb_serial_class : public Print {
public:
  void begin(long);
  int available();
  int read();
  int availableForWrite() override;
  size_t write(const uint8_t *bytes, size_t n) override;
};
extern usb_serial_class Serial;

class HardwareSerial : public Print {
public:
  void begin(uint32_t baud, uint16_t format = 0);
  int availableForWrite() override;
  size_t write(const uint8_t *bytes, size_t n) override;
};
extern HardwareSerial Serial1;

void setup();
void loop();
