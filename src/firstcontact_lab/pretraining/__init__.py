"""Pre-training of the network on random rigs: contacts, contexts, and training.

Terms of this package:

- A *context* is what the network knows of a rig: tokens, general features, and loudness of its
  signals. It is computed from pinches of flat blocks. Each rig has one context from all these
  pinches, and another from some of them.
- A *hint* is the closing speed of a pinch or the radius of its object, if known.
- *Valid samples* are those between a contact and the second contact.
"""
