"""Fast Marching Learning: demonstrations as a speed map that fast marching plans in."""
