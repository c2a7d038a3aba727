"""Models that learn a motion from demonstrations."""

from leadthrough.models.fast_marching import FastMarching, FastMarchingSkill

__all__ = ["FastMarching", "FastMarchingSkill"]
