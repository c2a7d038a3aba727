"""The demo: three arms learn to write, to pour and to harvest."""
