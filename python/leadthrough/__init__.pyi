from . import (
    arm as arm,
    demonstration_quality as demonstration_quality,
    errors as errors,
    guard as guard,
    io as io,
    models as models,
    motion_planning as motion_planning,
    planning as planning,
    preprocess as preprocess,
    reachability as reachability,
    rotations as rotations,
    shapes as shapes,
    show as show,
    simulation as simulation,
    tasks as tasks,
    timing as timing,
    trajectories as trajectories,
    validation as validation,
)
from .arm import Arm as Arm, DifferentialIk as DifferentialIk, DualArm as DualArm
from .augmentation import augment as augment
from .demonstration_quality import judge_demonstrations as judge_demonstrations
from .guard import Admission as Admission, Guard as Guard, connect as connect
from .io import (
    read_demonstrations as read_demonstrations,
    read_mesh as read_mesh,
    read_motion as read_motion,
    read_point_cloud as read_point_cloud,
    write_motion as write_motion,
)
from .models import (
    DMP as DMP,
    GMR as GMR,
    AlignedMean as AlignedMean,
    FastMarching as FastMarching,
    ProMP as ProMP,
    RhythmicDMP as RhythmicDMP,
    SkillLibrary as SkillLibrary,
    learn as learn,
    load_skill as load_skill,
)
from .motion import (
    Demonstration as Demonstration,
    Event as Event,
    JointTrajectory as JointTrajectory,
    PoseTrajectory as PoseTrajectory,
    Trajectory as Trajectory,
)
from .motion_planning import (
    PlannedMotion as PlannedMotion,
    Query as Query,
    plan_motion as plan_motion,
)
from .planning import Grid as Grid, arrival_times as arrival_times
from .shapes import (
    Box as Box,
    Capsule as Capsule,
    Cylinder as Cylinder,
    Mesh as Mesh,
    PointCloud as PointCloud,
    Scene as Scene,
    Sphere as Sphere,
)
from .simulation import SimulationReport as SimulationReport, simulate as simulate
from .timing import check_limits as check_limits, keep_timing as keep_timing, retime as retime
from .validation import validate as validate

__version__: str
