"""Grasp study: value of stiffness for policies that grip household objects on the twin's plant."""
