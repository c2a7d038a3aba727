"""Reproducible studies, one folder each, run by `leadthrough experiment`."""
