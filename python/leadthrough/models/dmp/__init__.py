"""Dynamic movement primitives of points, joints and poses, discrete and rhythmic."""
