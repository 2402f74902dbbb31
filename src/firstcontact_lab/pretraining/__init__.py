"""Pre-training of the network for any rig: random rigs, their contexts, and training."""
