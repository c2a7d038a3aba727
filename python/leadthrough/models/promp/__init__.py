"""Probabilistic movement primitives."""
