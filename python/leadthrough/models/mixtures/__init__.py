"""Gaussian mixtures and the regression with them."""
