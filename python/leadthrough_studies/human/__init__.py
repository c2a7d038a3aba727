"""What ProMPs keep of human and of damped-least-squares demonstrations (Yang et al.)."""
