"""What grasp modulation saves: all policies on the same pinches of the twin's hand plant."""
