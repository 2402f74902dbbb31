"""Finite-element simulations of a finger that touches an object, to check the simpler twin."""
