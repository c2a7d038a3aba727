"""Two ways past singularities of a Panda (Yang et al.)."""
