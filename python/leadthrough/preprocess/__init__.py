"""Turns recordings into what models learn from."""
