"""Rig models: the network, its rigs, and regressions on the pinches of one rig."""
