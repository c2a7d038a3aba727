"""A policy's chunks with the faults of networks and policies, followed at 1 kHz by four methods."""

from leadthrough_studies.chunks.study import STUDY

__all__ = ["STUDY"]
