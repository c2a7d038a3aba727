from . import (
    arm,
    demonstration_quality,
    errors,
    guard,
    io,
    models,
    motion_planning,
    planning,
    preprocess,
    reachability,
    rotations,
    shapes,
    show,
    simulation,
    tasks,
    timing,
    trajectories,
    validation,
)
from .arm import Arm, DifferentialIk
from .demonstration_quality import judge_demonstrations
from .events import Event
from .guard import Admission, Guard, connect
from .io import (
    read_demonstrations,
    read_mesh,
    read_motion,
    read_point_cloud,
    write_motion,
)
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
from .motion_planning import PlannedMotion, Query, plan_motion
from .planning import Grid, arrival_times
from .shapes import Box, Capsule, Cylinder, Mesh, PointCloud, Scene, Sphere
from .simulation import SimulationReport, simulate
from .timing import check_limits, keep_timing, retime
from .validation import validate

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
    "demonstration_quality",
    "errors",
    "guard",
    "io",
    "judge_demonstrations",
    "keep_timing",
    "load_skill",
    "models",
    "motion_planning",
    "plan_motion",
    "planning",
    "preprocess",
    "reachability",
    "read_demonstrations",
    "read_mesh",
    "read_motion",
    "read_point_cloud",
    "retime",
    "rotations",
    "shapes",
    "show",
    "simulate",
    "simulation",
    "tasks",
    "timing",
    "trajectories",
    "validate",
    "validation",
    "write_motion",
]
