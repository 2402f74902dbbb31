// A simulated Teensy 4.0 for the sketch on a PC: what ../stub declares.
//
// Its time is its own: instructions take none, a period of the timer, a write into flash, an erased
// sector and a look at micros() take what a board would need or what was asked for. The scans are the
// world: the n-th is what there is to read n periods after the first sample, whether read or not.
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
  int serial1 = -1;        // where Serial1 goes; nowhere below 0
  uint64_t cycles = 0;     // its time
  uint64_t busy_us = 0;    // that each look at micros() takes
  bool unread = false;     // time goes on though nobody reads what comes over USB
  bool ended = false;      // there are no more scans
  unsigned long cut = 0;   // in this operation on the flash the power goes; 0 for never
};
extern Board board;

// The flash is a file at its address on the board; 0, or -1 with errno set.
int open_flash(const char *path);

// Time goes on; interrupts come in it. false where the world waits for its feeder.
bool pass(uint64_t cycles);

// Up to the next interrupt; false as before, or where none is due at all.
bool pass_until_due();
