"""What ProMPs keep of human and of damped-least-squares demonstrations (Yang et al.)."""

from leadthrough_studies.human.study import STUDY

__all__ = ["STUDY"]
