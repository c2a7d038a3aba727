from . import (
    arm,
    errors,
    guard,
    io,
    judging,
    models,
    planning,
    preprocess,
    reaching,
    rotations,
    shapes,
    show,
    simulation,
    tasks,
    timing,
    trajectories,
    validation,
    whole_arm,
)
from .arm import Arm, DifferentialIk
from .events import Event
from .guard import Admission, Guard, connect
from .io import (
    read_demonstrations,
    read_mesh,
    read_motion,
    read_point_cloud,
    write_motion,
)
from .judging import judge_demonstrations
from .models import (
    DMP,
    GMR,
    FastMarching,
    ProMP,
    RhythmicDMP,
    SkillLibrary,
    load_skill,
)
from .motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory
from .planning import Grid, arrival_times
from .shapes import Box, Capsule, Cylinder, Mesh, PointCloud, Scene, Sphere
from .simulation import SimulationReport, simulate
from .timing import check_limits, differentiate, retime, scale_to_limits
from .validation import validate
from .whole_arm import PlannedMotion, Query, plan_motion

__version__: str

__all__ = [
    "DMP",
    "GMR",
    "Admission",
    "Arm",
    "Box",
    "Capsule",
    "Cylinder",
    "Demonstration",
    "DifferentialIk",
    "Event",
    "FastMarching",
    "Grid",
    "Guard",
    "JointTrajectory",
    "Mesh",
    "PlannedMotion",
    "PointCloud",
    "PoseTrajectory",
    "ProMP",
    "Query",
    "RhythmicDMP",
    "Scene",
    "SimulationReport",
    "SkillLibrary",
    "Sphere",
    "Trajectory",
    "arm",
    "arrival_times",
    "check_limits",
    "connect",
    "differentiate",
    "errors",
    "guard",
    "io",
    "judge_demonstrations",
    "judging",
    "load_skill",
    "models",
    "plan_motion",
    "planning",
    "preprocess",
    "reaching",
    "read_demonstrations",
    "read_mesh",
    "read_motion",
    "read_point_cloud",
    "retime",
    "rotations",
    "scale_to_limits",
    "shapes",
    "show",
    "simulate",
    "simulation",
    "tasks",
    "timing",
    "trajectories",
    "validate",
    "validation",
    "whole_arm",
    "write_motion",
]
