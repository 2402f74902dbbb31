// An example: lines for the hand's own controller on Serial1 (pin 1, 1 Mbaud).
//
//   C 0 1               contact of the index finger, the first of this closing
//   A 43.2 36.0 50.1    an answer: Shore A, and the ends of its interval
//   S 43.2 36.0 50.1    the same, of a contact like nothing that was learned from

#include "own_hand.h"

#include <Arduino.h>

static const int LONGEST = 48; // no line has more characters

void begin_own_hand() {
  Serial1.begin(1000000);
}

void on_contact(const fc_contact *contact, bool first) {
  if (Serial1.availableForWrite() < LONGEST) {
    return; // the line is full: better no line than to wait
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
