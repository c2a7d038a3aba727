"""Figures of objects by matplotlib: panels that describe them, their style and colours."""
