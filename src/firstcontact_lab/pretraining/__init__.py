"""Pre-training of the network on random rigs: contacts, contexts, and training.

Terms of this package:

- A *context* is what the network knows of a rig: tokens, general features, and signal level, all
  from some of the rig's block pinches. Each rig has several contexts, from different pinches.
- A *hint* is the closing speed of a pinch or the radius of its object, if known.
- *Valid samples* are those between a contact and the second contact.
"""
