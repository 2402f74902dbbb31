"""Grasp study: grips of household objects by the simulated hand, with and without stiffness."""
