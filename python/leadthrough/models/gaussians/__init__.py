"""Gaussian mixtures, fitted to points and regressed with, for the families that use them."""
