"""Types of the compiled module. A test compares names and arguments with the module.

Attributes are properties that cannot be set. A class whose name begins with an underscore has what
classes of the module have in common.
"""

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, Final, Self, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]
Float64Array = NDArray[np.float64]
Int32Array = NDArray[np.int32]
IndexArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
_FloatT = TypeVar("_FloatT", Float32Array, Float64Array)
# Errors, residuals and activations of tasks, and whether something limited them.
_TasksReport = tuple[Float64Array, Float64Array, Float64Array, BoolArray]
# Distance, sample, pair, fraction of the step, configuration and points.
_Nearest = tuple[float, int, int, float, Float64Array, Float64Array]

class Mimic:
    joint: Final[str]
    multiplier: Final[float]
    offset: Final[float]

class Joint:
    name: Final[str]
    kind: Final[str]
    mimic: Final[Mimic | None]
    parent: Final[int]
    child: Final[int]
    axis: Final[Float64Array]
    lower: Final[float]
    upper: Final[float]
    friction: Final[float]
    damping: Final[float]
    position: Final[Float64Array]
    rotation: Final[Float64Array]

class Geometry:
    kind: Final[str]
    sizes: Final[Float64Array]
    position: Final[Float64Array]
    angles: Final[Float64Array]
    file: Final[str]
    colour: Final[tuple[float, float, float] | None]

class Robot:
    def __init__(self, document: str) -> None: ...
    name: Final[str]
    links: Final[list[str]]
    joints: Final[list[str]]
    tree: Final[list[Joint]]
    leaves: Final[list[str]]
    meshes: Final[list[tuple[str, str, Float64Array]]]
    collisions: Final[dict[str, int]]
    inertias: Final[dict[str, tuple[float, Float64Array, Float64Array]]]
    def geometry(self, link: str, role: str) -> list[Geometry]: ...
    def path(self, base: str, tip: str) -> list[Joint]: ...
    def hold(self, values: Sequence[tuple[str, float]]) -> Robot: ...
    def with_inertias(
        self, bodies: dict[str, tuple[float, Float64Array, Float64Array]]
    ) -> Robot: ...

class IkTolerance:
    def __init__(self, position: float, orientation: float) -> None: ...

class IkAxes:
    def __init__(
        self, free: Sequence[bool], tolerance: Sequence[float], weight: Float64Array
    ) -> None: ...

class IkMode(Enum):
    FASTEST = ...
    CLOSEST = ...

class ClosedForm:
    deviation: Final[float]
    joints: Final[int]

class IkOptions:
    def __init__(
        self,
        tolerance: IkTolerance,
        axes: IkAxes | None,
        mode: IkMode,
        reference: Float64Array | None,
        nullspace_gain: float,
        posture: Float64Array | None,
        max_iterations: int,
        max_restarts: int,
        max_cpu_seconds: float,
        seed: int,
    ) -> None: ...

class YangOptions:
    def __init__(
        self,
        damping: float,
        alpha: float,
        condition_threshold: float,
        nullspace_gain: float,
        rotation_weight: float,
    ) -> None: ...

class TrackOptions:
    def __init__(
        self,
        tolerance: IkTolerance,
        max_iterations: int,
        max_step: float,
        axes: IkAxes | None = None,
    ) -> None: ...

class PursuitOptions:
    def __init__(
        self,
        velocity: Float64Array,
        acceleration: Float64Array,
        damping: float,
        deviation: IkTolerance,
    ) -> None: ...

class Chain:
    def __init__(self, robot: Robot, base: str, tip: str) -> None: ...
    joints: Final[int]
    joint_names: Final[list[str]]
    lower: Final[Float64Array]
    upper: Final[Float64Array]
    velocity: Final[Float64Array]
    effort: Final[Float64Array]
    middle: Final[Float64Array]
    mass: Final[float]
    reach: Final[float]
    def with_tool(self, position: Float64Array, orientation: Float64Array) -> Chain: ...
    def with_load(self, mass: float, center: Float64Array, inertia: Float64Array) -> Chain: ...
    def with_bounds(self, lower: Float64Array, upper: Float64Array) -> Chain: ...
    def forward_kinematics(self, q: Float64Array) -> tuple[Float64Array, Float64Array]: ...
    def pose(self, q: object) -> tuple[Float64Array, Float64Array] | None: ...

def jacobian_of_one(chain: Chain, q: object) -> Float64Array | None: ...
def jacobian(chain: Chain, q: Float64Array) -> Float64Array: ...
def jacobian_derivative(chain: Chain, q: Float64Array, qd: Float64Array) -> Float64Array: ...
def jacobian_second_derivative(
    chain: Chain, q: Float64Array, qd: Float64Array, qdd: Float64Array
) -> Float64Array: ...

class Dynamics:
    def __init__(self, chain: Chain) -> None: ...
    def inverse_dynamics(
        self, q: Float64Array, qd: Float64Array, qdd: Float64Array, gravity: Float64Array
    ) -> Float64Array: ...
    def mass_matrix(self, q: Float64Array) -> Float64Array: ...

class JointLaw:
    def __init__(
        self,
        dynamics: Dynamics,
        gravity: Float64Array,
        rotors: Float64Array,
        of_motion: tuple[float, float],
        springs: Float64Array,
        dampers: Float64Array,
        model: str,
    ) -> None: ...
    def torques(self, target: Float64Array, q: Float64Array, qd: Float64Array) -> Float64Array: ...

class Drives:
    def __init__(
        self,
        values: Float64Array,
        late: int,
        period: float,
        steps: int,
        fastest: float,
        start: Float64Array,
        joints: IndexArray,
        state: Sequence[Float64Array],
    ) -> None: ...
    torques: Float64Array
    demanded: Float64Array
    ticks: int
    def begin(self, command: Float64Array, progress: float, law: object) -> int: ...
    def act(self, step: int) -> None: ...
    def advance(self) -> int: ...
    def end(self) -> None: ...
    def run(
        self,
        q: Float64Array,
        qd: Float64Array,
        qdd: Float64Array,
        progress: Float64Array,
        law: object,
        step: Callable[[], bool],
        touched: Callable[[int], None],
        periods_after_touch: int,
    ) -> tuple[Any, ...]: ...

class ErrorLoop:
    def __init__(
        self, values: Float64Array, period: float, steps: int, late: int, every: int
    ) -> None: ...
    smooth: Float64Array
    dry: Float64Array
    diverged: int
    def advance(
        self,
        ease: Float64Array,
        answer: Float64Array,
        left: Float64Array,
        q: Float64Array,
        qd: Float64Array,
        qdd: Float64Array,
    ) -> Float64Array: ...

class Shape:
    def distances(self, points: Float64Array) -> Float64Array: ...

class Frame:
    def __init__(self, chain: Chain, offset: Float64Array) -> None: ...

class ArmTask: ...

class TaskStack:
    def __init__(
        self,
        chain: Chain,
        tasks: Sequence[ArmTask],
        velocity: Float64Array,
        acceleration: Float64Array,
        reverse: bool,
        rest_damping: float,
    ) -> None: ...
    def velocity(
        self, q: Float64Array, qd: Float64Array, dt: float
    ) -> tuple[Float64Array, _TasksReport]: ...
    def acceleration(
        self, q: Float64Array, qd: Float64Array, dt: float
    ) -> tuple[Float64Array, _TasksReport]: ...
    def step(
        self, q: Float64Array, qd: Float64Array, dt: float
    ) -> tuple[Float64Array, Float64Array, _TasksReport]: ...

class DifferentialIk:
    def __init__(
        self,
        chain: Chain,
        velocity: Float64Array,
        acceleration: Float64Array,
        posture: Float64Array,
        dt: float,
        gain: float,
        posture_gain: float,
    ) -> None: ...
    def step(
        self,
        q: Float64Array,
        qd: Float64Array,
        position: Float64Array,
        orientation: Float64Array,
        twist: Float64Array,
    ) -> tuple[Float64Array, Float64Array, float, float]: ...

def primitive_shape(
    kind: str, sizes: Float64Array, position: Float64Array, orientation: Float64Array
) -> Shape: ...
def hulls_shape(
    corners: Sequence[Float64Array], position: Float64Array, orientation: Float64Array
) -> Shape: ...
def cloud_shape(
    points: Float64Array, radius: float, position: Float64Array, orientation: Float64Array
) -> Shape: ...
def pose_task(
    frame: Frame,
    position: Float64Array,
    orientation: Float64Array,
    twist: Float64Array,
    gain: float,
    damping_ratio: float,
) -> ArmTask: ...
def position_task(
    frame: Frame, position: Float64Array, velocity: Float64Array, gain: float, damping_ratio: float
) -> ArmTask: ...
def direction_task(
    frame: Frame, axis: Float64Array, direction: Float64Array, gain: float, damping_ratio: float
) -> ArmTask: ...
def cone_task(
    frame: Frame,
    axis: Float64Array,
    direction: Float64Array,
    cosine: float,
    margin: float,
    gain: float,
    damping_ratio: float,
) -> ArmTask: ...
def posture_task(
    q: Float64Array, velocity: Float64Array, gain: float, damping_ratio: float
) -> ArmTask: ...
def joint_limit_task(margin: float, gain: float, damping_ratio: float) -> ArmTask: ...
def plane_task(
    frame: Frame, direction: Float64Array, height: float, gain: float, damping_ratio: float
) -> ArmTask: ...
def clearance_task(
    frame: Frame,
    shape: Shape,
    distance: float,
    margin: float,
    gain: float,
    damping_ratio: float,
) -> ArmTask: ...
def resolve_stack(
    jacobians: Sequence[Float64Array],
    wanted: Sequence[Float64Array],
    lower: Float64Array,
    upper: Float64Array,
    reverse: bool,
) -> Float64Array: ...

class CollisionModel:
    def __init__(
        self,
        robot: Robot,
        chain: Chain,
        base: str,
        tip: str,
        meshes: Sequence[Sequence[Float64Array]],
        attached: Sequence[Shape],
    ) -> None: ...
    def beside(
        self,
        right: CollisionModel,
        position: Float64Array,
        orientation: Float64Array,
        one_robot: bool,
        shared_object: bool,
        joint_names: Sequence[str],
    ) -> CollisionModel: ...
    chain: Final[Chain]
    bodies: Final[list[str]]
    pairs: Final[list[tuple[str, str]]]
    left_out: Final[list[list[str]]]

class CollisionScene:
    names: Final[list[str]]

def itself(model: CollisionModel) -> CollisionScene: ...
def against(model: CollisionModel, obstacles: Sequence[Shape]) -> CollisionScene: ...
def nearest_bodies(
    scene: CollisionScene, q: Float64Array, threads: int
) -> tuple[Float64Array, Int32Array, Float64Array]: ...
def check_motion(
    scene: CollisionScene, q: Float64Array, margin: float, tolerance: float, threads: int
) -> tuple[Float64Array, _Nearest, _Nearest | None]: ...
def longest_step(scene: CollisionScene, q: Float64Array) -> float: ...
def clear_batch(
    model: CollisionModel,
    obstacles: Sequence[Shape],
    q: Float64Array,
    margin: float,
    self_collision_margin: float,
) -> list[bool]: ...
def clear_edges(
    model: CollisionModel,
    obstacles: Sequence[Shape],
    starts: Float64Array,
    ends: Float64Array,
    margin: float,
    self_collision_margin: float,
    threads: int,
) -> list[bool]: ...
def connect(
    model: CollisionModel,
    obstacles: Sequence[Shape],
    start: Float64Array,
    goals: Float64Array,
    lower: Float64Array,
    upper: Float64Array,
    margin: float,
    self_collision_margin: float,
    seed: int,
    steps: int,
) -> Float64Array: ...

class StepLimits:
    def __init__(
        self,
        lower: Float64Array,
        upper: Float64Array,
        velocity: Float64Array,
        acceleration: Float64Array,
        jerk: Float64Array,
        period: float,
    ) -> None: ...

class GuardedScene:
    def __init__(
        self,
        model: CollisionModel,
        obstacles: Sequence[Shape],
        growth: Sequence[float],
        margin: float,
        self_collision_margin: float,
    ) -> None: ...

def first_excess(
    limits: StepLimits, start: Float64Array, samples: Float64Array
) -> tuple[int, int, int, float] | None: ...
def with_rates(
    times: Float64Array, positions: Float64Array, start: Float64Array, period: float
) -> Float64Array: ...
def brake(limits: StepLimits, start: Float64Array) -> Float64Array: ...
def bridge_to_start(
    limits: StepLimits, start: Float64Array, target: Float64Array, most_steps: int
) -> tuple[Float64Array, int] | None: ...
def bridge_on_time(
    limits: StepLimits, start: Float64Array, target: Float64Array, most_steps: int
) -> tuple[Float64Array, int] | None: ...
def joined(
    limits: StepLimits, start: Float64Array, target: Float64Array, jerk: Float64Array, use: float
) -> Float64Array: ...
def slowed(
    limits: StepLimits, path: Float64Array, most_samples: int
) -> tuple[Float64Array, Float64Array] | None: ...
def stopped(
    limits: StepLimits, start: Float64Array, path: Float64Array
) -> tuple[Float64Array, Float64Array] | None: ...
def eased(
    limits: StepLimits, start: Float64Array, path: Float64Array, rate: float
) -> tuple[Float64Array, Float64Array] | None: ...
def first_contact(
    scene: GuardedScene,
    start: Float64Array,
    samples: Float64Array,
    age: float,
    most_work: int = ...,
) -> tuple[float, str, str] | None: ...
def clear_path(
    chain: Chain,
    model: CollisionModel | None,
    obstacles: Sequence[Shape],
    positions: Float64Array,
    orientations: Float64Array,
    axes: IkAxes | None,
    postures: Float64Array,
    start: Float64Array | None,
    margin: float,
    self_collision_margin: float,
    tolerance: IkTolerance,
    tube: Float64Array = ...,
    max_attempts: int = 3,
) -> tuple[
    Float64Array,
    Float64Array | None,
    float,
    list[tuple[str, str, int]],
    tuple[float, float, str, str] | None,
]: ...
def recognize(chain: Chain) -> ClosedForm | None: ...
def solve_ik(
    chain: Chain,
    position: Float64Array,
    orientation: Float64Array,
    q0: Float64Array,
    options: IkOptions,
    form: ClosedForm | None,
) -> tuple[Float64Array, int, float, float, int, int]: ...
def solve_ik_batch(
    chain: Chain,
    positions: Float64Array,
    orientations: Float64Array,
    starts: Float64Array,
    options: IkOptions,
    threads: int,
    form: ClosedForm | None,
    own_restarts: bool,
) -> tuple[Float64Array, Int32Array, Float64Array, Float64Array, Int32Array, NDArray[np.bool_]]: ...
def solve_ik_all(
    chain: Chain,
    position: Float64Array,
    orientation: Float64Array,
    q0: Float64Array,
    options: IkOptions,
    count: int,
    separation: float,
    form: ClosedForm | None,
) -> tuple[Float64Array, Float64Array, Float64Array, Int32Array, int, bool, float]: ...
def solve_yang(
    chain: Chain,
    positions: Float64Array,
    orientations: Float64Array,
    starts: Float64Array,
    tolerance: IkTolerance,
    max_iterations: int,
    options: YangOptions,
    threads: int,
) -> tuple[Float64Array, Int32Array, Float64Array, Float64Array, Int32Array, NDArray[np.bool_]]: ...
def yang_path(
    chain: Chain,
    positions: Float64Array,
    orientations: Float64Array,
    start: Float64Array,
    steps: Float64Array,
    options: YangOptions,
) -> tuple[Float64Array, Float64Array, Float64Array, Float64Array, Float64Array]: ...
def track(
    chain: Chain,
    positions: Float64Array,
    orientations: Float64Array,
    start: Float64Array,
    postures: Float64Array,
    shares: Float64Array,
    options: TrackOptions,
) -> tuple[Float64Array, Float64Array, Float64Array]: ...
def pursue(
    chain: Chain,
    times: Float64Array,
    positions: Float64Array,
    orientations: Float64Array,
    start: Float64Array,
    postures: Float64Array,
    shares: Float64Array,
    options: PursuitOptions,
) -> tuple[Float64Array, Float64Array, Float64Array]: ...
def slow_down(
    times: Float64Array, q: Float64Array, velocity: Float64Array, acceleration: Float64Array
) -> tuple[Float64Array, int]: ...
def resting_places(states: Float64Array, limits: Float64Array) -> Float64Array: ...
def times_to_rest(
    states: Float64Array, limits: Float64Array, targets: Float64Array
) -> Float64Array: ...
def step_each(
    states: Float64Array, limits: Float64Array, targets: Float64Array, period: float
) -> Float64Array: ...
def step_together(
    states: Float64Array, limits: Float64Array, targets: Float64Array, period: float
) -> Float64Array: ...
def so3_exp(rotation_vectors: Float64Array) -> Float64Array: ...
def so3_log(quaternions: Float64Array) -> Float64Array: ...
def so3_compose(a: Float64Array, b: Float64Array) -> Float64Array: ...
def so3_to_matrix(quaternions: Float64Array) -> Float64Array: ...
def so3_from_matrix(matrices: Float64Array) -> Float64Array: ...
def so3_distance(a: Float64Array, b: Float64Array) -> Float64Array: ...
def so3_slerp(a: Float64Array, b: Float64Array, fractions: Float64Array) -> Float64Array: ...
def so3_slerp_through(
    times: Float64Array, quaternions: Float64Array, at: Float64Array
) -> Float64Array: ...
def so3_mean(layers: Float64Array, weights: Float64Array) -> tuple[Float64Array, Float64Array]: ...
def so3_lift(quaternions: Float64Array) -> tuple[Float64Array, int]: ...
def so3_left_jacobian(rotation_vectors: Float64Array) -> Float64Array: ...
def so3_left_jacobian_inverse(rotation_vectors: Float64Array) -> Float64Array: ...
def so3_integrate(
    times: Float64Array, angular_velocities: Float64Array, start: Float64Array
) -> Float64Array: ...
def dtw_distance(a: Float64Array, b: Float64Array, band: int) -> float: ...
def dtw_path(a: Float64Array, b: Float64Array) -> Int32Array: ...
def frechet_distance(a: Float64Array, b: Float64Array, band: int) -> float: ...
def rms_apart(curves: Float64Array) -> Float64Array: ...
def arc_lengths(points: Float64Array) -> Float64Array: ...
def by_arc_length(points: Float64Array, count: int) -> Float64Array | None: ...

class DmpForces:
    def __init__(
        self, nodes: Float64Array, fade: Float64Array, rate: float, rhythmic: bool
    ) -> None: ...
    nodes: Final[Float64Array]
    fade: Final[Float64Array]

class _Superposed:
    def superposed(
        self,
        phase: float,
        until: float,
        value: Float64Array,
        slope: Float64Array,
        shift: Float64Array,
    ) -> Self: ...

class DmpPath(_Superposed):
    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, breaks: Float64Array, coefficients: Float64Array) -> None: ...
    start: Final[Float64Array]
    end: Final[Float64Array]

class DmpCourse(_Superposed):
    def __init__(
        self,
        breaks: Float64Array,
        coefficients: Float64Array,
        gain: Float64Array,
        drive: Float64Array,
    ) -> None: ...
    breaks: Final[Float64Array]
    coefficients: Final[Float64Array]
    gain: Final[Float64Array]
    drive: Final[Float64Array]

class DmpCurve:
    def __init__(
        self,
        controls: Float64Array,
        steps: Float64Array,
        speeds: Float64Array,
        covered: Float64Array,
        zyz: bool,
        rhythmic: bool,
    ) -> None: ...
    steps: Final[Float64Array]
    covered: Final[Float64Array]

class AvoidanceScene:
    def __init__(
        self,
        shapes: Sequence[Shape],
        margins: Float64Array,
        reach: float,
        lower: Float64Array,
        upper: Float64Array,
    ) -> None: ...

class _State:
    course: Final[DmpCourse]
    value: Final[Float64Array]
    slope: Final[Float64Array]
    phase: Final[float]
    duration: Final[float]
    position: Final[Float64Array]
    velocity: Final[Float64Array]
    def coast(self, forces: DmpForces, dt: float) -> Self: ...
    def tick(self, forces: DmpForces, dt: float) -> Self | None: ...
    def pushed(self, forces: DmpForces, dt: float, acceleration: Float64Array) -> Self: ...
    def led_around(
        self, forces: DmpForces, dt: float, acceleration: Float64Array, scene: AvoidanceScene
    ) -> Self: ...

class PointState(_State):
    def __init__(
        self,
        course: DmpCourse,
        value: Float64Array,
        slope: Float64Array,
        phase: float,
        duration: float,
    ) -> None: ...

class PoseState(_State):
    def __init__(
        self,
        course: DmpCourse,
        value: Float64Array,
        slope: Float64Array,
        phase: float,
        duration: float,
        curve: DmpCurve,
        offset: DmpPath,
    ) -> None: ...
    curve: Final[DmpCurve]
    offset: Final[DmpPath]
    orientation: Final[Float64Array]
    pose: Final[Float64Array]
    angular_velocity: Final[Float64Array]

def dmp_rollout(
    forces: DmpForces,
    course: DmpCourse,
    value: Float64Array,
    slope: Float64Array,
    phases: Float64Array,
) -> tuple[Float64Array, Float64Array]: ...
def dmp_rollout_around(
    forces: DmpForces,
    course: DmpCourse,
    scene: AvoidanceScene,
    value: Float64Array,
    slope: Float64Array,
    phases: Float64Array,
) -> tuple[Float64Array, Float64Array, float]: ...
def dmp_shifted_course(
    breaks: Float64Array,
    coefficients: Float64Array,
    progress: Float64Array,
    start: Float64Array,
    goal: Float64Array,
) -> DmpCourse: ...
def dmp_offset(
    wanted: Float64Array, demonstrated: Float64Array, near: Float64Array
) -> Float64Array: ...
def dmp_orientations(
    curve: DmpCurve,
    offset: DmpPath,
    phases: Float64Array,
    values: Float64Array,
) -> Float64Array: ...
def dmp_poses(
    forces: DmpForces, state: PoseState, phases: Float64Array
) -> tuple[Float64Array, Float64Array]: ...
def dmp_peak_speeds(
    forces: DmpForces, state: PoseState, phases: Float64Array
) -> tuple[float, float]: ...
def dmp_coordinates(
    curve: DmpCurve,
    offset: DmpPath,
    phase: float,
    orientation: Float64Array,
    velocity: Float64Array,
    near: Float64Array,
) -> tuple[Float64Array, Float64Array]: ...
def sample_truncated_gaussian(
    walls: Float64Array, limits: Float64Array, start: Float64Array, velocities: Float64Array
) -> Float64Array: ...
def condition_weights(
    mean: Float64Array,
    covariance: Float64Array,
    basis: Float64Array,
    columns: NDArray[np.int64],
    values: Float64Array,
    noise: Float64Array,
    scale: Float64Array,
    least: float,
) -> tuple[bool, Float64Array, Float64Array]: ...
def condition_at(
    mean: Float64Array,
    covariance: Float64Array,
    centres: Float64Array,
    sharpness: float,
    periodic: bool,
    scale: Float64Array,
    duration: float,
    time: object,
    position: object,
    noise: object,
    least: float,
) -> tuple[Float64Array, Float64Array] | None: ...
def all_finite(values: Float64Array) -> bool: ...
def is_finite_vector(value: object, size: object) -> bool: ...
def unit_quaternion(value: object, tolerance: float) -> Float64Array | None: ...
def product(left: Float64Array, right: Float64Array) -> Float64Array: ...
def solve_definite(matrix: Float64Array, right: Float64Array) -> Float64Array: ...
def is_covariance(matrix: Float64Array) -> bool: ...
def normalised_basis(
    phases: Float64Array,
    centres: Float64Array,
    sharpness: float,
    periodic: bool,
    order: int,
) -> Float64Array: ...
def curves_over(
    basis: Float64Array, bases: int, weights: Float64Array, most: int, threads: int
) -> tuple[list[Float64Array], bool]: ...
def curves_over_basis(
    phases: Float64Array,
    centres: Float64Array,
    sharpness: float,
    periodic: bool,
    factors: Float64Array,
    weights: Float64Array,
    most: int,
    threads: int,
) -> tuple[list[Float64Array], bool]: ...
def march(
    speed: _FloatT,
    spacing: Sequence[float],
    cells: NDArray[np.int64],
    order: int,
    source_radius: float,
    stop: int,
) -> _FloatT: ...
def march_batch(
    speeds: Sequence[_FloatT],
    spacing: Sequence[float],
    cells: Sequence[NDArray[np.int64]],
    order: int,
    source_radius: float,
    threads: int,
) -> list[_FloatT]: ...

class Cells:
    def __init__(
        self, shape: Sequence[int], spacing: Sequence[float], first: Sequence[float]
    ) -> None: ...

class Walls:
    def __init__(
        self,
        cells: Cells,
        margin: float,
        shapes: Sequence[Shape],
        middles: Float64Array,
        half_extents: Float64Array,
    ) -> None: ...
    def distances(self, cells: NDArray[np.int64], most: float) -> Float64Array: ...

class SpeedMap:
    def at(self, cells: NDArray[np.int64]) -> Float64Array: ...
    def fastest(self, level: int, blocks: NDArray[np.int64]) -> Float64Array: ...
    def quickest(
        self, start: Sequence[float], goal: Sequence[float]
    ) -> tuple[str, Float64Array]: ...

class FreeSpeedMap(SpeedMap): ...

def given_speeds(cells: Cells, outside: float, speeds: Float64Array) -> SpeedMap: ...
def experience_speeds(
    cells: Cells, saturation: float, paths: Sequence[Float64Array], radius: float
) -> FreeSpeedMap: ...
def tube_speeds(
    cells: Cells,
    saturation: float,
    paths: Sequence[Float64Array],
    weights: Sequence[float],
    radius: float,
) -> FreeSpeedMap: ...
def hindered_speeds(free: SpeedMap, walls: Walls, reach: float) -> SpeedMap: ...
def saturated_speeds(free: SpeedMap, walls: Walls, reach: float, saturation: float) -> SpeedMap: ...
def passable_speeds(free: FreeSpeedMap, walls: Walls, band: float, reach: float) -> SpeedMap: ...

class ArrivalFieldFloat32:
    def __init__(
        self, speed: Float32Array, spacing: Sequence[float], cells: NDArray[np.int64]
    ) -> None: ...
    def update(self, low: Sequence[int], speed: Float32Array) -> tuple[str, int]: ...
    def times(self) -> Float32Array: ...

class ArrivalFieldFloat64:
    def __init__(
        self, speed: Float64Array, spacing: Sequence[float], cells: NDArray[np.int64]
    ) -> None: ...
    def update(self, low: Sequence[int], speed: Float64Array) -> tuple[str, int]: ...
    def times(self) -> Float64Array: ...

def nearest_sources(
    arrival: Float64Array, spacing: Sequence[float], cells: Sequence[int]
) -> Int32Array: ...
def distance_transform(mask: NDArray[np.bool_], spacing: Sequence[float]) -> Float64Array: ...
def descend(
    arrival: Float32Array | Float64Array,
    spacing: Sequence[float],
    start: Sequence[float],
    goal: Sequence[float],
    step: float,
) -> tuple[str, Float64Array]: ...

class MarchingPolicy:
    def __init__(
        self,
        arrival: Float32Array | Float64Array,
        spacing: Float64Array,
        origin: Float64Array,
        goal: Float64Array,
        positions: Float64Array,
        speeds: Float64Array,
        mean_speed: float,
        slowing: float,
        barrier: tuple[Float64Array, Float64Array, float, float] | None,
    ) -> None: ...
    def velocities(self, points: Float64Array) -> tuple[int, Float64Array]: ...
    def moved(self, points: Float64Array, span: float) -> tuple[int, Float64Array]: ...

def directions(
    arrival: Float32Array | Float64Array, spacing: Sequence[float], points: Float64Array
) -> tuple[str, int, Float64Array]: ...
def time_lines(
    points: Float64Array,
    velocity: Float64Array,
    acceleration: Float64Array,
    jerk: Float64Array,
    period: float,
    longest: float,
) -> tuple[int, IndexArray, Float64Array]: ...
def step_extremes(
    times: Float64Array,
    positions: Float64Array,
    velocities: Float64Array,
    accelerations: Float64Array,
) -> tuple[Float64Array, Float64Array]: ...
def motion_peaks(
    times: Float64Array,
    positions: Float64Array,
    velocities: Float64Array,
    accelerations: Float64Array,
) -> tuple[Float64Array, Float64Array, Float64Array]: ...
def fit_spline(
    parameters: Float64Array, q: Float64Array, tolerance: float, corners: bool
) -> tuple[IndexArray, Float64Array]: ...
def smooth_spline(
    parameters: Float64Array,
    q: Float64Array,
    tolerance: float,
    lower: Float64Array,
    upper: Float64Array,
) -> tuple[IndexArray, Float64Array]: ...
def polynomial_values(
    knots: Float64Array, coefficients: Float64Array, times: Float64Array, order: int
) -> Float64Array: ...
def bezier_values(points: Float64Array, fractions: Float64Array) -> Float64Array: ...
def cubic_through(parameters: Float64Array, q: Float64Array) -> Float64Array: ...
def spline_slopes(parameters: Float64Array, q: Float64Array, at_rest: bool) -> Float64Array: ...
def rows_apart(q: Float64Array, tolerance: float) -> IndexArray: ...

class RecordLayout:
    def __init__(
        self, texts: Sequence[str], counts: Sequence[int], separator: str, integers: int = 0
    ) -> None: ...

def write_records(values: Float64Array, layout: RecordLayout) -> bytes: ...
def read_records(block: bytes, layout: RecordLayout) -> tuple[Float64Array, int]: ...

class TimedPath:
    def __init__(
        self,
        breaks: Float64Array,
        coefficients: Float64Array,
        scale: Float64Array,
        points: int,
        also: Float64Array,
    ) -> None: ...
    length: Final[Float64Array]
    parameter: Final[Float64Array]
    slope: Final[Float64Array]
    positions: Final[Float64Array]
    first: Final[Float64Array]
    second: Final[Float64Array]
    def law(
        self,
        velocity: Float64Array,
        acceleration: Float64Array,
        jerk: Float64Array,
        fastest: Float64Array,
        gain: Float64Array,
        bend: Float64Array,
        lower: Float64Array,
        upper: Float64Array,
        period: float,
        parts: int,
        start_speed: float,
        end_speed: float,
        longest: float,
        most_delay: float,
    ) -> tuple[
        int, int, Float64Array, Float64Array, Float64Array, float, float, int, IndexArray
    ]: ...
    def states_along(
        self, length: Float64Array, speed: Float64Array, push: Float64Array
    ) -> tuple[Float64Array, Float64Array, Float64Array]: ...
