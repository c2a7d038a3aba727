"""leadthrough: hand-guided demonstrations in, executable robot-arm motion out."""

from leadthrough import errors, io, rotations
from leadthrough.arm import Arm
from leadthrough.io import read_demonstrations
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.planning import Grid, arrival_times
from leadthrough.shapes import Box, Capsule, Sphere

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "Box",
    "Capsule",
    "Demonstration",
    "Grid",
    "JointTrajectory",
    "PoseTrajectory",
    "Sphere",
    "Trajectory",
    "arrival_times",
    "errors",
    "io",
    "read_demonstrations",
    "rotations",
]
