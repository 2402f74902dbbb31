// What the hand does by itself with what it feels, computer or none: yours to write, in own_hand.cpp.
//
// These run in loop(), a few ms after a contact and then each ms: they must not wait. Samples are
// taken meanwhile; what takes longer than a ms makes the next answer late, and then it is left out.
#pragma once

#include "fc_answers.h"

// Once, before the first sample.
void begin_own_hand();

// A finger touches: contact->channel is 0 for the index finger, 1 for the thumb. first: of this closing.
void on_contact(const fc_contact *contact, bool first);

// How stiff what is touched is: answer->value, with its interval from answer->low to answer->high, in
// Shore A. answer->flags has FC_REFUSES where the signal cannot be used and there is no answer, and
// FC_STRANGE where it is like nothing that was learned from.
void on_answer(const fc_told *answer);
