"""Turns recordings into what models learn from."""

from leadthrough.preprocess.segment import segment

__all__ = ["segment"]
