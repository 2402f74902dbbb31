// Callbacks for the hand, called with and without a computer. Write yours in own_hand.cpp.
//
// They run in loop(), a few ms after a contact and then each ms, and must not wait. Sampling continues
// meanwhile. A callback that takes longer than 1 ms makes the next estimate late, and it is skipped.
#pragma once

#include "fc_predictor.h"

// Called once, before the first sample.
void begin_own_hand();

// Called with each event of the chain; fc_chain.h lists the kinds. The most important ones:
// - FC_CONTACT_FOUND: a finger touches. event->channel is 0 for the index finger, 1 for the thumb.
//   event->flags has FC_IS_FIRST for the first contact of a closing.
// - FC_CONTACT_WITHDRAWN: the first contact was a mistake. Ignore it and its estimates.
// - FC_ESTIMATED: event->estimate.value with its interval from .low to .high, in Shore A.
//   event->flags has FC_IS_OUT_OF_RANGE if the contact is out of range, and FC_IS_FINAL for one
//   event that repeats the estimate to keep. It comes late: act on the newest estimate.
// - FC_NOT_ESTIMATED: the signal cannot be used, and there is no estimate.
//
// A hand that measures its closing speed passes it to fc_predictor_hint, from loop().
void on_event(const fc_event *event);
