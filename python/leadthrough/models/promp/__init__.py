"""Probabilistic movement primitives (ProMPs): normal distributions over motions."""
