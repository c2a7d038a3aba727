"""The demo: learns handwriting, plans it and writes it with a UR3."""
