// Example that sends lines to the hand's own controller on Serial1 (pin 1, 1 Mbaud).
//
//   C 0 1               contact of the index finger, the first of this closing
//   A 43.2 36.0 50.1    estimate: Shore A and the ends of its interval
//   S 43.2 36.0 50.1    estimate for a contact that is out of range

#include "own_hand.h"

#include <Arduino.h>

static const int LONGEST = 48; // characters of the longest line

void begin_own_hand() {
  Serial1.begin(1000000);
}

void on_contact(const fc_contact *contact, bool first) {
  if (Serial1.availableForWrite() < LONGEST) {
    return; // the buffer is full: drop the line instead of waiting
  }
  Serial1.print("C ");
  Serial1.print((int)contact->channel);
  Serial1.println(first ? " 1" : " 0");
}

void on_answer(const fc_told *answer) {
  if ((answer->flags & FC_REFUSES) || Serial1.availableForWrite() < LONGEST) {
    return;
  }
  Serial1.print(answer->flags & FC_STRANGE ? "S " : "A ");
  Serial1.print(answer->value, 1);
  Serial1.print(" ");
  Serial1.print(answer->low, 1);
  Serial1.print(" ");
  Serial1.println(answer->high, 1);
}
