// Two fingertips on a Teensy 4.0: piezo, 3 x 2 force array and contact strip each.
//
// THIS SKETCH HAS NOT RUN ON HARDWARE. It compiles against a stub of the Teensy's headers,
// and the core that it calls is tested on a PC and on an emulated Cortex-M7. What is left to
// try: pins, converter, timer, USB and EEPROM.
//
// Open it from firmware/build/firstcontact/, which `make -C firmware sketch-folder` makes:
// the core's sources have to lie beside it.

#include <avr/eeprom.h>

#include "fc_device.h"
#include "fc_layout.h"
#include "fc_pace.h"
#include "pins.h"

// IntervalTimer counts a clock of 24 MHz.
static const uint32_t TIMER_HZ = 24000000;
static const float TICKS_PER_MICROSECOND = 24.0f;
static const uint32_t RING = 4096; // 0.83 s

static const char descriptor[] = FC_DESCRIPTOR_TEXT("teensy40", "real");
DMAMEM static fc_sample slots[RING];
static fc_device device;
static fc_pace pace;
static IntervalTimer timer;

static float next_period() {
  return fc_pace_next(&pace) / TICKS_PER_MICROSECOND;
}

// Drives one row of each array; the others float. It has until the next sample to settle.
static void select_taxel() {
  const uint8_t row = fc_scan_row(&device.scan);
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    for (uint8_t r = 0; r < 3; r++) {
      pinMode(ROW_PIN[f][r], r == row ? OUTPUT : INPUT);
    }
    digitalWrite(ROW_PIN[f][row], HIGH);
  }
}

static void take_sample() {
  timer.update(next_period()); // of the period after the one that now runs
  const uint8_t column = fc_scan_column(&device.scan);
  fc_raw raw;
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    raw.piezo[f] = analogRead(PIEZO_PIN[f]);
  }
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    raw.force[f] = analogRead(COLUMN_PIN[f][column]);
    raw.strip[f] = digitalRead(STRIP_PIN[f]) == LOW; // the object is grounded
  }
  fc_device_sample(&device, &raw);
  select_taxel();
}

// Another number after each start.
static uint32_t count_boot() {
  uint32_t *const place = nullptr; // the EEPROM's first word
  const uint32_t boot = eeprom_read_dword(place) + 1;
  eeprom_write_dword(place, boot);
  return boot;
}

void setup() {
  Serial.begin(0); // USB: there is no baud rate
  analogReadResolution(10);
  analogReadAveraging(1);
  for (uint8_t f = 0; f < FC_FINGERS; f++) {
    pinMode(STRIP_PIN[f], INPUT_PULLUP);
  }
  fc_device_init(&device, descriptor, count_boot(), slots, RING);
  fc_pace_init(&pace, TIMER_HZ, FC_RATE_HZ);
  select_taxel();
  delay(1); // until the first row has settled
  timer.begin(take_sample, next_period());
}

void loop() {
  while (fc_device_listens(&device) && Serial.available() > 0) {
    fc_device_hear(&device, (uint8_t)Serial.read());
  }
  size_t n;
  const uint8_t *const bytes = fc_device_outgoing(&device, &n);
  const int room = Serial.availableForWrite();
  if (n > 0 && room > 0) {
    fc_device_sent(&device, Serial.write(bytes, n < (size_t)room ? n : (size_t)room));
  }
}
