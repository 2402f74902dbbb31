"""Grasp study: benefit of knowing the stiffness for policies that grip simulated objects."""
