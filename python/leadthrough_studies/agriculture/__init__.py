"""Orientation primitives on agricultural tasks of a TIAGo (Lauretti et al. 2023)."""
