"""leadthrough: hand-guided demonstrations in, executable robot-arm motion out."""

from leadthrough import (
    arm,
    errors,
    io,
    planning,
    preprocess,
    rotations,
    timing,
    trajectories,
)
from leadthrough.arm import Arm, DifferentialIk
from leadthrough.events import Event
from leadthrough.io import read_demonstrations, write_motion
from leadthrough.models import (
    DMP,
    GMR,
    FastMarching,
    PoseDMP,
    ProMP,
    RhythmicDMP,
    RhythmicPoseDMP,
    SkillLibrary,
    load_skill,
)
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.planning import Grid, arrival_times
from leadthrough.shapes import Box, Capsule, Sphere
from leadthrough.timing import check_limits, differentiate, retime, scale_to_limits

__version__ = "0.1.0"

__all__ = [
    "DMP",
    "GMR",
    "Arm",
    "Box",
    "Capsule",
    "Demonstration",
    "DifferentialIk",
    "Event",
    "FastMarching",
    "Grid",
    "JointTrajectory",
    "PoseDMP",
    "PoseTrajectory",
    "ProMP",
    "RhythmicDMP",
    "RhythmicPoseDMP",
    "SkillLibrary",
    "Sphere",
    "Trajectory",
    "arm",
    "arrival_times",
    "check_limits",
    "differentiate",
    "errors",
    "io",
    "load_skill",
    "planning",
    "preprocess",
    "read_demonstrations",
    "retime",
    "rotations",
    "scale_to_limits",
    "timing",
    "trajectories",
    "write_motion",
]
