"""Pre-training of the network on random rigs: contacts, contexts, and training.

Terms of this package:

- A *context* is what the network knows of a rig: tokens, general features, and signal level, all
  from block pinches. Each rig has one context from all its block pinches, and others from some.
- A *hint* is the closing speed of a pinch or the radius of its object, if known.
- *Valid samples* are those between a contact and the second contact.
"""
