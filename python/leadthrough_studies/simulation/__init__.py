"""Motions of the other studies in simulation."""

from leadthrough_studies.simulation.study import STUDY

__all__ = ["STUDY"]
