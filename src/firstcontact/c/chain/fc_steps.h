/* Steps of the chain, which its files share. Programs call the functions of fc_chain.h only.

   Comments name each argument with its direction and unit. A pointer can be NULL only if they say
   "or NULL". */
#ifndef FC_STEPS_H
#define FC_STEPS_H

#include "fc_chain.h"

/* Pass an event to the program.
   c       in
   event   in
   kind    in, such as FC_SKIPPED
   reason  in, such as FC_DONE
   flags   in, such as FC_IS_FIRST
   sample  in, number of the event's sample
   known   in, number of the last sample that the event depends on */
void fc_chain_send(const fc_chain *c, const fc_event *event);
void fc_chain_emit(const fc_chain *c, int32_t kind, int32_t reason, int32_t flags, int64_t sample,
                   int64_t known);

/* Forget the contacts of this closing and their estimates.
   c  in, out */
void fc_contacts_forget(fc_chain *c);

/* Return true if each channel has had a contact.
   c  in */
bool fc_contacts_all_latched(const fc_chain *c);

/* Detect contacts with the newest sample. Return true if it shows a second contact.
   c          in, out
   is_finite  in, true if the sample is finite in all channels */
bool fc_contacts_detect(fc_chain *c, bool is_finite);

/* Compute the estimates that are due with the newest sample.
   c               in, out
   has_new_second  in, true if this sample shows the second contact */
void fc_estimates_compute(fc_chain *c, bool has_new_second);

/* Report the final estimate: the newest one that uses only samples before the second contact.
   c       in, out
   known   in, number of the last sample that decides about it
   reason  in, reported if there is no estimate */
void fc_estimates_settle(fc_chain *c, int64_t known, int32_t reason);

/* Return the number of the sample from which on no second contact can lie within the newest estimate.
   Onsets are placed up to `search` samples back.
   c  in */
int64_t fc_estimates_final_from(const fc_chain *c);

#endif
