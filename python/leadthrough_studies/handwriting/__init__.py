"""The demo: handwriting learned, planned and written by a UR3."""
