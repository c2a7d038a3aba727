"""Motions by Gaussian mixture regression over time."""
