// Example that sends lines to the hand's own controller on Serial1 (pin 1, 1 Mbaud).
//
//   C 0 1               contact of the index finger, the first of this closing
//   W 0                 this contact is withdrawn
//   A 43.2 36.0 50.1    estimate: Shore A and the ends of its interval
//   S 43.2 36.0 50.1    estimate for a contact that is out of range

#include "own_hand.h"

#include <Arduino.h>

static const int LONGEST = 48; // characters of the longest line

void begin_own_hand() {
  Serial1.begin(1000000);
}

static void print_estimate(const fc_estimate *estimate) {
  Serial1.print(estimate->value, 1);
  Serial1.print(" ");
  Serial1.print(estimate->low, 1);
  Serial1.print(" ");
  Serial1.println(estimate->high, 1);
}

void on_event(const fc_event *event) {
  const bool is_final = event->flags & FC_IS_FINAL;
  if (Serial1.availableForWrite() < LONGEST) {
    return; // the buffer is full: drop the line instead of waiting
  }
  if (event->kind == FC_CONTACT_FOUND) {
    Serial1.print("C ");
    Serial1.print((int)event->channel);
    Serial1.println(event->flags & FC_IS_FIRST ? " 1" : " 0");
  } else if (event->kind == FC_CONTACT_WITHDRAWN) {
    Serial1.print("W ");
    Serial1.print((int)event->channel);
    Serial1.println("");
  } else if (event->kind == FC_ESTIMATED && !is_final) {
    Serial1.print(event->flags & FC_IS_OUT_OF_RANGE ? "S " : "A ");
    print_estimate(&event->estimate);
  }
}
