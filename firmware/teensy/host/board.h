// Simulated Teensy 4.0 that runs the sketch on a PC. It implements what ../stub declares.
//
// Time is simulated. Instructions take none. A period of the timer, a write to flash and an erased
// sector take as long as on a board; a call of micros() takes the time that was set. The n-th scan is
// what the pins show n periods after the first sample, whether it is read or not.
#pragma once

#include <stdint.h>

extern "C" {
#include "feed.h"
#include "line.h"
}

static const uint64_t CYCLES_A_SECOND = 600000000;
static const uint64_t SECTOR_CYCLES = CYCLES_A_SECOND / 1000 * 45, PAGE_CYCLES = CYCLES_A_SECOND / 2500;

struct Board {
  line usb;
  feed scans;
  int serial1 = -1;        // file of Serial1; below 0 for none
  uint64_t cycles = 0;     // simulated time
  uint64_t busy_us = 0;    // time of each call of micros()
  bool unread = false;     // time continues although no host reads USB
  bool ended = false;      // no more scans
  unsigned long cut = 0;   // flash operation during which the power fails; 0 for none
};
extern Board board;

// Map a file at the flash's address on the board. Return 0, or -1 with errno set.
int open_flash(const char *path);

// Advance the time and run the interrupts that fall due. Return false if scans are missing.
bool pass(uint64_t cycles);

// Advance to the next interrupt. Return false if scans are missing or no interrupt is set.
bool pass_until_due();
