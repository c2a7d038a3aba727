"""Small drawings of objects, as SVG for notebooks and as figures of matplotlib.

What can be drawn says so as panels of lines; both renderers draw the same panels.
"""
