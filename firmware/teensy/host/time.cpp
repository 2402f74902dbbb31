// Simulated time, timer and pins.
#include <Arduino.h>

#include "board.h"
#include "fc_pace.h"
#include "pins.h"

#include <stdio.h>
#include <stdlib.h>

volatile uint32_t ARM_DWT_CYCCNT;
extern "C" {
volatile uint32_t F_CPU_ACTUAL = CYCLES_A_SECOND;
}

static void (*interrupt)();
static uint64_t due, period;
static uint64_t first_sample; // time of the first sample, taken or not
static fc_raw now; // the present scan
static uint64_t scans_read;
static uint8_t mode[32], level[32];
static int charge; // level that the converter read last, with some of it in the next reading

static uint64_t cycles_of(float microseconds) {
  // Teensyduino rounds to whole ticks of 24 MHz.
  return (uint64_t)(24.0f * microseconds + 0.5f) * (CYCLES_A_SECOND / 24000000);
}

static void set_time(uint64_t cycles) {
  board.cycles = cycles;
  ARM_DWT_CYCCNT = (uint32_t)cycles;
}

// Read the scan of a moment. A moment up to one microsecond early gives the same scan.
static bool look(uint64_t cycles) {
  const uint64_t early = CYCLES_A_SECOND / 1000000;
  const uint64_t number =
      (uint64_t)((unsigned __int128)(cycles + early - first_sample) * FC_RATE_HZ / CYCLES_A_SECOND);
  while (scans_read <= number) {
    const feed_state state = feed_next(&board.scans, &now);
    board.ended = state == FEED_END;
    if (state != FEED_SCAN) {
      return false;
    }
    scans_read++;
  }
  return true;
}

bool pass(uint64_t cycles) {
  const uint64_t until = board.cycles + cycles;
  while (interrupt != nullptr && due <= until) {
    if (!look(due)) {
      return false;
    }
    set_time(due);
    due += period; // an update does not change the present period
    interrupt();
  }
  set_time(until);
  return true;
}

bool pass_until_due() {
  return interrupt != nullptr && pass(due > board.cycles ? due - board.cycles : 0);
}

bool IntervalTimer::begin(void (*function)(), float microseconds) {
  interrupt = function;
  period = cycles_of(microseconds);
  due = board.cycles + period;
  if (first_sample == 0) {
    first_sample = due;
  }
  return true;
}

void IntervalTimer::update(float microseconds) {
  period = cycles_of(microseconds);
}

void IntervalTimer::end() {
  interrupt = nullptr;
}

uint32_t micros() {
  (void)pass(board.busy_us * (CYCLES_A_SECOND / 1000000));
  return (uint32_t)(board.cycles / (CYCLES_A_SECOND / 1000000));
}

void delay(uint32_t milliseconds) {
  (void)pass(milliseconds * (CYCLES_A_SECOND / 1000));
}

void pinMode(uint8_t pin, uint8_t to) {
  mode[pin] = to;
}

void digitalWrite(uint8_t pin, uint8_t to) {
  level[pin] = to;
}

void analogReadResolution(unsigned int) {}
void analogReadAveraging(unsigned int) {}

uint8_t digitalRead(uint8_t pin) {
  return pin == STRIP_PIN[0] || pin == STRIP_PIN[1] ? !now.strip[pin == STRIP_PIN[1]] : level[pin];
}

// An array can be read only while exactly one row is driven.
static int force(uint8_t finger) {
  int driven = 0;
  for (uint8_t pin : ROW_PIN[finger]) {
    driven += mode[pin] == OUTPUT && level[pin] == HIGH;
  }
  if (driven != 1) {
    fputs("an array is read with other than one row driven\n", stderr);
    abort();
  }
  return now.force[finger];
}

// A pin behind a large resistor cannot take the converter's charge along within one reading.
static int behind_divider(int value) {
  const int reading = value + (charge - value) / 128;
  charge = value;
  return reading;
}

int analogRead(uint8_t pin) {
  if (mode[pin] != INPUT_DISABLE) {
    fprintf(stderr, "the keeper of pin %d is on\n", pin);
    abort();
  }
  for (uint8_t f = 0; f < 2; f++) {
    if (pin == PIEZO_PIN[f]) {
      return charge = now.piezo[f];
    }
    if (pin == COLUMN_PIN[f][0] || pin == COLUMN_PIN[f][1]) {
      return behind_divider(force(f));
    }
  }
  fprintf(stderr, "pin %d is no converter's\n", pin);
  abort();
}
