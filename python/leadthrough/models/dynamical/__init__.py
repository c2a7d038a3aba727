"""Motions as autonomous dynamical systems that come to the goal from everywhere."""
