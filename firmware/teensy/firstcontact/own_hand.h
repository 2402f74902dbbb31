// Callbacks for the hand, with or without a computer. Write yours in own_hand.cpp.
//
// They run in loop(), a few ms after a contact and then each ms, and must not wait. Sampling continues
// meanwhile. A callback that takes longer than 1 ms makes the next estimate late, and it is skipped.
#pragma once

#include "fc_answers.h"

// Called once, before the first sample.
void begin_own_hand();

// Called when a finger touches. contact->channel is 0 for the index finger, 1 for the thumb. first is
// true for the first contact of a closing.
void on_contact(const fc_contact *contact, bool first);

// Called with each estimate: answer->value with its interval from answer->low to answer->high, in
// Shore A. answer->flags has FC_REFUSES if the signal cannot be used and there is no estimate, and
// FC_STRANGE if the contact is out of range.
void on_answer(const fc_told *answer);
