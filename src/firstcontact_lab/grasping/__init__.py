"""What stiffness is worth to a hand: policies on a household of things, on the twin's plant."""
