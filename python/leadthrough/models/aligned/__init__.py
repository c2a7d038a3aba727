"""The mean of aligned demonstrations, conditioned on its ends."""
