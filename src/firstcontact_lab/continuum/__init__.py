"""Finite-element simulations of a finger that touches an object. They check the simpler twin."""
