"""Models of one rig (a hand with its sensors): the adapted network, and regressions."""
