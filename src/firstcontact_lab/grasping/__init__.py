"""Grasp study: picks by simulated hands, with policies that use or ignore the stiffness.

Terms:

- A *kind* is a household object by name, such as "raspberry". Its specimens differ at random.
- A *family* is a group of similar kinds. A *fold* is a group of whole families, held out together.
- *Settings* are the tuned numbers of a policy, such as forces.
- A policy is *tuned* on the picks of some hands and specimens, and *judged* on the picks of others.
- The *table of closings* holds the forces of every pick at each approach speed and grip force. Most
  results are computed from it. A *full closing* is simulated anew, with detector, model and loop.
- A *success* is a pick whose object is neither dropped nor damaged.
- A *slip reflex* raises the grip force when the object slips; the *boost* is its factor.
- The *limit* of an object is the contact force that damages it.
- The *gain* from stiffness is the relative reduction of drops at 10 % damage, unless stated
  otherwise. A *control* measures the gain after weights or limits were swapped between kinds.
- A *resample* is a random draw of picks with replacement, for bootstrap intervals.
"""
