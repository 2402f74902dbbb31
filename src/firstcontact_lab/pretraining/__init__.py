"""Makes the network that any rig uses: random rigs, their contexts, and training."""
