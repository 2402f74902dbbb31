"""Pre-training of the network on random rigs: contacts, contexts, and training.

Terms of this package:

- A *context* is what the network knows of a rig: features of its pinches of flat blocks (tokens,
  one per Shore A), general features, and the loudness of its signals. Each rig has one context
  from all its block pinches, and another from some of them.
- A *hint* is the closing speed of a pinch or the radius of its object, if known.
- *Valid samples* are those between a contact and the second contact. A *stage* is a number of
  valid samples for which contexts are computed.
- *Random rigs* are simulated hands with random parameters. A *family* changes their structure.
"""
