"""Calls of every binding of the compiled core, with what is known of their results."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import _core as core

# Arguments that may be None; some answer with None to whatever is not plainly right.
OPTIONAL = {
    "IkOptions": ("axes", "reference", "posture"),
    "TrackOptions": ("axes",),
    "clear_path": ("axes", "model", "start"),
    "condition_at": ("time", "position", "noise"),
    "pose": ("q",),
    "jacobian_of_one": ("q",),
}
CALLS: list[tuple[Callable[..., Any], dict[str, Any], Any]] = []
MADE: list[Any] = []


def call(function: Callable[..., Any], expected: Any, **arguments: Any) -> None:
    """Notes a call; `expected` is its first result, or nothing that can be compared."""
    CALLS.append((function, arguments, expected))


def make(function: Callable[..., Any], **arguments: Any) -> Any:
    """Notes a call and returns its result, which other calls need."""
    call(function, None, **arguments)
    MADE.append(function(**arguments))
    return MADE[-1]


def rows(*values: float, count: int = 2) -> np.ndarray:
    return np.tile(np.array(values, float), (count, 1))


ONE, X, Y = rows(1, 0, 0, 0), rows(1, 0, 0), rows(0, 1, 0)
QUARTER = rows(np.sqrt(0.5), 0, 0, np.sqrt(0.5))  # about z
HALF_PI_Z = rows(0, 0, np.pi / 2)
TURN = rows(0, -1, 0, 1, 0, 0, 0, 0, 1)
NOTHING = np.zeros(0)

# Rotations.
call(core.so3_exp, QUARTER, rotation_vectors=HALF_PI_Z)
call(core.so3_log, HALF_PI_Z, quaternions=QUARTER)
call(core.so3_compose, QUARTER, a=QUARTER, b=ONE)
call(core.so3_to_matrix, TURN, quaternions=QUARTER)
call(core.so3_from_matrix, QUARTER, matrices=TURN)
call(core.so3_distance, [np.pi / 2] * 2, a=ONE, b=QUARTER)
call(core.so3_slerp, QUARTER, a=ONE, b=QUARTER, fractions=np.ones(2))
call(core.so3_mean, QUARTER[:1], layers=QUARTER, weights=np.ones(2))
call(core.so3_lift, 2 * HALF_PI_Z, quaternions=core.so3_exp(2 * HALF_PI_Z))
call(core.so3_left_jacobian, rows(*np.eye(3).ravel()), rotation_vectors=0 * X)
call(core.so3_left_jacobian_inverse, rows(*np.eye(3).ravel()), rotation_vectors=0 * X)
TURNING = {"times": np.array([0.0, 1.0]), "angular_velocities": HALF_PI_Z, "start": ONE[0]}
call(core.so3_integrate, [ONE[0], QUARTER[0]], **TURNING)

# Fields of arrival times: a map without walls, left from one corner.
MAP, CORNER, SPACING = np.ones((3, 4)), np.array([0]), [1.0, 1.0]
STRAIGHT = np.array([[0.0, 1.0, 2.0, 3.0]])
LOOSELY = {"order": 1, "source_radius": 0.0}
for real in (np.float32, np.float64):
    name = np.dtype(real).name
    here = {"spacing": SPACING, "cells": CORNER, "stop": -1, **LOOSELY}
    call(getattr(core, f"march_{name}"), STRAIGHT, speed=np.ones((1, 4), real), **here)
    call(
        getattr(core, f"march_batch_{name}"),
        STRAIGHT[None],
        speeds=[np.ones((1, 4), real)],
        spacing=SPACING,
        cells=[CORNER],
        threads=2,
        **LOOSELY,
    )
    arrivals = make(
        getattr(core, f"ArrivalField{name.capitalize()}"),
        speed=MAP.astype(real),
        spacing=SPACING,
        cells=CORNER,
    )
    call(arrivals.update, "repair", low=[2, 3], speed=np.full((1, 1), 0.5, real))
    call(arrivals.times, None)
    down = {"arrival": np.tile(STRAIGHT, (3, 1)).astype(real), "spacing": SPACING}
    call(core.descend, "ok", start=[1.0, 3.0], goal=[1.0, 0.0], step=0.5, **down)
    call(core.directions, "ok", points=np.array([[1.0, 2.0]]), **down)
call(core.nearest_sources, np.zeros((1, 4)), arrival=STRAIGHT, spacing=SPACING, cells=[0])
call(core.distance_transform, STRAIGHT, mask=STRAIGHT == 0.0, spacing=SPACING)

# An arm.
robot = make(core.Robot, document=(Path(__file__).parent / "flat.urdf").read_text())
chain = make(core.Chain, robot=robot, base="base", tip="tip")
Q, REST, SPEED = np.array([[0.0, np.pi / 2], [0.3, -0.4]]), np.zeros((2, 2)), np.full(2, 2.0)
CORNER_OF_ARM = np.array([1.0, 1.0, 0.0])
BENT, LOOSE = np.array([0.1, 1.4]), np.full(2, 9.0)
call(robot.path, None, base="base", tip="tip")
call(robot.hold, None, values=[("j2", 0.5)])
MADE += make(robot.geometry, link="upper", role="collision")
call(chain.forward_kinematics, [CORNER_OF_ARM], q=Q[:1])
call(chain.pose, CORNER_OF_ARM, q=Q[0])
call(chain.with_tool, None, position=X[0], orientation=ONE[0])
call(chain.with_load, None, mass=1.0, center=X[0], inertia=np.eye(3))
call(chain.with_bounds, None, lower=-SPEED, upper=SPEED)
J = np.array([-1, -1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1])
call(core.jacobian, [J], chain=chain, q=Q[:1])
call(core.jacobian_of_one, J.reshape(6, 2), chain=chain, q=Q[0])
call(core.jacobian_derivative, np.zeros((2, 12)), chain=chain, q=Q, qd=REST)
call(core.jacobian_second_derivative, np.zeros((2, 12)), chain=chain, q=Q, qd=REST, qdd=REST)
call(core.inverse_dynamics, REST, chain=chain, q=Q, qd=REST, qdd=REST, gravity=np.zeros(3))
call(core.mass_matrix, None, chain=chain, q=Q)

# Inverse kinematics.
tolerance = make(core.IkTolerance, position=1e-6, orientation=1e-6)
axes = make(core.IkAxes, free=[False] * 6, tolerance=[1.0] * 6, weight=np.ones(6))
options = make(
    core.IkOptions,
    tolerance=tolerance,
    axes=axes,
    mode=core.IkMode.CLOSEST,
    reference=BENT,
    nullspace_gain=0.0,
    posture=BENT,
    max_iterations=50,
    max_restarts=3,
    max_cpu_seconds=10.0,
    seed=0,
)
yang = make(
    core.YangOptions,
    damping=0.1,
    alpha=0.0,
    condition_threshold=50.0,
    nullspace_gain=0.0,
    rotation_weight=0.3,
)
FREE = np.zeros((0, 4))
ONE_POSE = {"chain": chain, "position": CORNER_OF_ARM, "orientation": QUARTER[0]}
POSES = {"chain": chain, "positions": rows(*CORNER_OF_ARM), "orientations": QUARTER}
FOUND = np.tile(Q[0], (2, 1))
call(core.solve_ik, Q[0], q0=BENT, options=options, **ONE_POSE)
call(core.solve_ik_all, Q[:1], q0=BENT, options=options, count=1, separation=0.1, **ONE_POSE)
call(core.solve_ik_batch, FOUND, starts=rows(*BENT), options=options, threads=2, **POSES)
yang_call = {"starts": rows(*BENT), "tolerance": tolerance, "max_iterations": 99, "threads": 2}
call(core.solve_yang, None, options=yang, **yang_call, **POSES)
call(core.yang_path, FOUND, start=Q[0], steps=np.ones(2), options=yang, **POSES)
preferred = {"start": Q[0], "postures": np.full((2, 2), np.nan), "shares": np.zeros(2)}
follow = make(core.TrackOptions, tolerance=tolerance, max_iterations=50, max_step=1.0, axes=axes)
call(core.track, FOUND, options=follow, **preferred, **POSES)
pursuit = make(
    core.PursuitOptions, velocity=SPEED, acceleration=LOOSE, damping=0.0, deviation=tolerance
)
call(core.pursue, FOUND, times=np.array([0.0, 1.0]), options=pursuit, **preferred, **POSES)
differential = make(
    core.DifferentialIk,
    chain=chain,
    velocity=SPEED,
    acceleration=LOOSE,
    posture=np.full(2, np.nan),
    dt=0.01,
    gain=1.0,
    posture_gain=0.0,
)
AT_REST = {"q": Q[0], "qd": REST[0]}
POSE = {"position": CORNER_OF_ARM, "orientation": QUARTER[0], "twist": np.zeros(6)}
call(differential.step, Q[0], **AT_REST, **POSE)

# Stacks of tasks.
frame = make(core.Frame, chain=chain, offset=np.zeros(3))
there = {"position": X[0], "orientation": ONE[0]}
ball = make(core.primitive_shape, kind="sphere", sizes=np.array([0.1]), **there)
make(core.primitive_shape, kind="box", sizes=X[0] + 1, **there)
ROUND = {"sizes": np.array([0.1, 1.0]), **there}
make(core.primitive_shape, kind="capsule", **ROUND)
pin = make(core.primitive_shape, kind="cylinder", **ROUND)
CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
make(core.hulls_shape, corners=[CUBE, CUBE + 3], **there)
make(core.cloud_shape, points=CUBE, radius=0.1, **there)
call(pin.distances, [0.9, -0.1], points=np.stack([X[0] + Y[0], X[0]]))
pace = {"gain": 1.0, "damping_ratio": 1.0}
AXES = {"axis": X[0], "direction": Y[0]}
tasks = [
    make(core.pose_task, frame=frame, **POSE, **pace),
    make(core.position_task, frame=frame, position=CORNER_OF_ARM, velocity=0 * X[0], **pace),
    make(core.direction_task, frame=frame, **AXES, **pace),
    make(core.cone_task, frame=frame, cosine=0.5, margin=0.1, **AXES, **pace),
    make(core.posture_task, q=Q[0], velocity=REST[0], **pace),
    make(core.joint_limit_task, margin=0.1, **pace),
    make(core.plane_task, frame=frame, direction=Y[0], height=1.0, **pace),
    make(core.clearance_task, frame=frame, shape=ball, distance=0.1, margin=0.1, **pace),
]
limits = {"velocity": SPEED, "acceleration": LOOSE}
stack = make(core.TaskStack, chain=chain, tasks=tasks, reverse=False, rest_damping=1.0, **limits)
call(stack.velocity, REST[0], dt=0.01, **AT_REST)
call(stack.acceleration, REST[0], dt=0.01, **AT_REST)
call(stack.step, Q[0], dt=0.01, **AT_REST)
box = {"lower": -LOOSE, "upper": LOOSE, "reverse": False}
call(core.resolve_stack, SPEED, jacobians=[np.eye(2)], wanted=[SPEED], **box)

# Collisions: the eye is a cube of 2 m below the arm, the obstacle a ball of 1 m above its tip.


def sphere(radius, position):
    return core.primitive_shape("sphere", np.array([radius]), position, ONE[0])


BALL = [sphere(1.0, np.array([1.0, 1.0, 4.0]))]
attached = [sphere(0.1, np.zeros(3))]
ends = {"base": "base", "tip": "tip"}
shapes = {"meshes": [CUBE], "attached": attached}
model = make(core.CollisionModel, robot=robot, chain=chain, **ends, **shapes)
scene = make(core.against, model=model, obstacles=BALL)
call(core.itself, None, model=model)
call(core.nearest_bodies, [2.9], scene=scene, q=Q[:1], threads=2)
call(core.check_motion, [2.9] * 2, scene=scene, q=Q[[0, 0]], margin=0.1, tolerance=1e-3, threads=2)
call(core.longest_step, 0.0, scene=scene, q=Q[[0, 0]])
margins = {"margin": 0.1, "self_collision_margin": 0.0}
call(core.clear_batch, [True], model=model, obstacles=BALL, q=Q[:1], **margins)
tip = {key: POSES[key] for key in ("positions", "orientations")}
call(
    core.clear_path,
    FOUND,
    chain=chain,
    model=model,
    obstacles=BALL,
    axes=None,
    postures=np.full((2, 2), np.nan),
    start=Q[0],
    tolerance=tolerance,
    tube=np.empty((0, 6)),
    max_attempts=1,
    **tip,
    **margins,
)

# Dynamic movement primitives without a learned force.
NODES, BREAKS = np.zeros((3, 2)), np.array([0.0, 1.0])
RISE = np.outer([0.0, 0.0, 0.0, 10.0, -15.0, 6.0], [1.0, 2.0])
forces = make(core.DmpForces, nodes=NODES, fade=np.zeros(3), rate=12.5, rhythmic=False)
forces6 = core.DmpForces(np.zeros((3, 6)), np.zeros(3), 12.5, False)
path = core.DmpPath()
bent = make(core.DmpPath, breaks=BREAKS, coefficients=np.zeros((6, 3)))
course = make(core.DmpCourse, breaks=BREAKS, coefficients=RISE, gain=np.ones(2), drive=np.zeros(2))
course6 = core.DmpCourse(BREAKS, np.zeros((6, 6)), np.ones(6), np.zeros(6))
SHIFT = {"start": X[0, :2], "goal": X[0, :2]}
make(core.dmp_shifted_course, breaks=BREAKS, coefficients=RISE, progress=RISE, **SHIFT)
curve = make(
    core.DmpCurve,
    controls=rows(1, 0, 0, 0, count=4),
    steps=np.zeros((3, 3)),
    speeds=np.zeros(2),
    covered=np.zeros(2),
    zyz=False,
    rhythmic=False,
)
shifted = {"phase": 0.5, "until": 1.0}
call(course.superposed, None, value=SPEED, slope=SPEED, shift=SPEED, **shifted)
call(bent.superposed, None, value=X[0], slope=X[0], shift=X[0], **shifted)
scene = make(
    core.AvoidanceScene,
    shapes=[sphere(1.0, 9 * X[0]), core.primitive_shape("box", X[0] + 1, 9 * X[0], ONE[0])],
    margins=np.full(2, 0.1),
    reach=0.1,
    lower=NOTHING,
    upper=NOTHING,
)
start = {"phase": 0.0, "duration": 1.0}
point = make(core.PointState, course=course, value=REST[0], slope=REST[0], **start)
pose = make(
    core.PoseState,
    course=course6,
    value=np.zeros(6),
    slope=np.zeros(6),
    curve=curve,
    offset=bent,
    **start,
)
for state, learned, size in ((point, forces, 2), (pose, forces6, 6)):
    push = np.zeros(size)
    call(state.coast, None, forces=learned, dt=0.1)
    call(state.tick, None, forces=learned, dt=0.1)
    call(state.pushed, None, forces=learned, dt=0.1, acceleration=push)
    call(state.led_around, None, forces=learned, dt=0.1, acceleration=push, scene=scene)
phases = {"phases": BREAKS, "value": REST[0], "slope": REST[0]}
rolled = {"forces": forces, "course": course, **phases}
call(core.dmp_rollout, [[0, 0], [1, 2]], **rolled)
call(core.dmp_rollout_around, [[0, 0], [1, 2]], scene=scene, **rolled)
call(core.dmp_offset, HALF_PI_Z[0], wanted=QUARTER[0], demonstrated=ONE[0], near=0 * X[0])
on_curve = {"curve": curve, "offset": bent}
call(core.dmp_orientations, ONE, phases=BREAKS, values=np.zeros((2, 3)), **on_curve)
call(core.dmp_poses, None, forces=forces6, state=pose, phases=BREAKS)
call(core.dmp_peak_speeds, None, forces=forces6, state=pose, phases=BREAKS)
spin = {"orientation": QUARTER[0], "velocity": 0 * X[0], "near": 0 * X[0]}
call(core.dmp_coordinates, HALF_PI_Z[0], phase=0.5, **spin, **on_curve)

# Time: one joint to and fro under limits, a straight path of two joints.
BOUNDS = np.array([[2.0], [3.0], [9.0]] * 2)
STATE, TARGET = np.array([[0.5], [0.0], [0.0]]), np.array([0.5])
call(core.resting_places, [0.5], states=STATE, limits=BOUNDS)
for step in (core.step_each, core.step_together):
    call(step, STATE, states=STATE, limits=BOUNDS, targets=TARGET, period=0.01)
call(core.times_to_rest, [0.0], states=STATE, limits=BOUNDS, targets=TARGET)
call(core.slow_down, [0.0, 1.0], times=BREAKS, q=REST, velocity=SPEED, acceleration=SPEED)
timed = make(
    core.TimedPath,
    breaks=BREAKS,
    coefficients=np.outer([0.0, 1.0, 0.0, 0.0], [1.0, -1.0]),
    scale=np.full(2, 0.5),
    points=9,
)
none = np.zeros((9, 0))
call(
    timed.law,
    0,
    velocity=SPEED,
    acceleration=LOOSE,
    jerk=np.full(2, 99.0),
    fastest=np.full(9, np.inf),
    gain=none,
    bend=none,
    lower=none,
    upper=none,
    period=0.01,
    parts=1,
    start_speed=0.0,
    end_speed=0.0,
    longest=1e5,
    most_delay=20.0,
)
still = {"length": np.zeros(1), "speed": np.zeros(1), "push": np.zeros(1)}
call(timed.states_along, [[0.0, 0.0]], **still)
LINE = np.array([[0.0, 0.0], [1.0, -1.0]])
rates = {"velocity": SPEED, "acceleration": LOOSE, "jerk": np.full(2, 99.0)}
call(core.time_lines, -1, points=LINE, period=0.01, longest=1e5, **rates)
sampled = {"positions": LINE, "velocities": 0 * LINE, "accelerations": 0 * LINE}
call(core.step_extremes, None, times=np.array([0.0, 1.0]), **sampled)
call(core.motion_peaks, None, times=np.array([0.0, 1.0]), **sampled)
ramp = np.linspace(0.0, 1.0, 20)
call(core.fit_spline, [0, 4, 9, 14, 19], parameters=ramp, q=ramp[:, None], tolerance=1e-9)
NARROW = {"lower": np.zeros(1), "upper": np.full(1, ramp[-1])}
call(
    core.smooth_spline,
    [0, 3, 6, 9, 12, 15, 19],
    parameters=ramp,
    q=ramp[:, None],
    tolerance=1e-9,
    **NARROW,
)
call(core.rows_apart, [0, 1], q=LINE, tolerance=1e-9)

# Objects of other sizes, which go with none of the above.
short = core.Chain(robot, "base", "lower")
OTHERS = [
    core.itself(model),
    *robot.tree,
    *(joint.mimic for joint in robot.tree if joint.mimic is not None),
    core.IkMode.FASTEST,
    short,
    forces6,
    course6,
    path,
    core.IkOptions(tolerance, axes, core.IkMode.CLOSEST, X[0], 0.0, X[0], 50, 3, 9.0, 0),
    core.PursuitOptions(X[0] + 1, X[0] + 1, 0.0, tolerance),
    core.Frame(short, np.zeros(3)),
    core.posture_task(X[0], X[0], 1.0, 1.0),
    core.against(core.CollisionModel(robot, short, "base", "lower", [CUBE], attached[:0]), BALL),
    core.DmpPath(BREAKS, np.zeros((6, 2))),
    core.DmpCurve(rows(1, 0, 0, 0, count=5), np.zeros((4, 3)), BREAKS, BREAKS, False, False),
]

# Calls of what computes in some cells of a map only.
CELLS = make(core.Cells, shape=[3, 4], spacing=[2.0, 1.0], first=[10.0, 20.0])
PATH = np.array([[10.0, 20.0], [10.0, 20.5]])
TUBE = make(core.tube_speeds, cells=CELLS, saturation=0.5, paths=[PATH], weights=[1.0], radius=1.0)
call(TUBE.at, [0.75, 0.5], cells=np.array([1, 4]))
call(TUBE.fastest, [1.0, 0.5], level=1, blocks=np.array([0, 3]))
WALLS = make(
    core.Walls,
    cells=CELLS,
    margin=0.5,
    shapes=[sphere(0.1, np.array([10.0, 20.0, 0.0]))],
    middles=np.array([[10.0, 20.0, 0.0]]),
    half_extents=np.full((1, 3), 0.1),
)
call(WALLS.distances, [0.0, 1.0, 1.5], cells=np.array([0, 1, 2]), most=1.5)
SOME = {"cells": np.array([0, 1, 2])}
GIVEN = make(core.given_speeds, cells=CELLS, outside=0.0, speeds=np.arange(12.0).reshape(3, 4))
call(GIVEN.at, [0.0, 1.0, 2.0], **SOME)
call(GIVEN.fastest, [5.0, 7.0, 9.0, 11.0], level=1, blocks=np.arange(4))
call(GIVEN.quickest, "found", start=[10.0, 22.0], goal=[14.0, 23.0])
EXPERIENCE = make(core.experience_speeds, cells=CELLS, saturation=0.5, paths=[PATH], radius=1.0)
call(EXPERIENCE.at, [1.0, 0.5], cells=np.array([0, 3]))
HINDERED = make(core.hindered_speeds, free=GIVEN, walls=WALLS, reach=2.0)
call(HINDERED.at, [0.0, 0.5, 2.0], **SOME)
SATURATED = make(core.saturated_speeds, free=GIVEN, walls=WALLS, reach=2.0, saturation=0.6)
call(SATURATED.at, [0.0, 0.5, 2.0], **SOME)
PASSABLE = make(core.passable_speeds, free=TUBE, walls=WALLS, band=1.0, reach=3.0)
call(PASSABLE.at, [0.0, 1.0, 0.5], **SOME)

# Calls of what evaluates and makes curves.
ENDS = np.vstack([ONE[0], QUARTER[0]])
call(core.so3_slerp_through, ENDS, times=BREAKS, quaternions=ENDS, at=BREAKS)
SQUARE = {"knots": BREAKS, "coefficients": np.ones((3, 1))}
call(core.polynomial_values, [[3.0], [5.0]], **SQUARE, times=BREAKS + 1.0, order=1)
HALF = np.array([0.5])
call(core.bezier_values, [[0.5, 1.0]], points=np.array([[0.0, 2.0], [1.0, 0.0]]), fractions=HALF)
SLOPE = {"parameters": 2.0 * BREAKS, "q": np.array([[0.0], [2.0]])}
call(core.cubic_through, [[0.0], [1.0], [0.0], [0.0]], **SLOPE)
call(core.spline_slopes, [[0.0], [0.0]], **SLOPE, at_rest=True)

# Calls of the guard: limits of 1, 0.1 and 0.01 rad per s, s^2 and s^3, two joints, 1 Hz.
ROOMY = np.full(2, 10.0)
limits = make(
    core.StepLimits,
    lower=-ROOMY,
    upper=ROOMY,
    velocity=np.ones(2),
    acceleration=np.full(2, 0.1),
    jerk=np.full(2, 0.01),
    period=1.0,
)
REST = np.zeros((1, 6))
SLOW = np.zeros((6, 6))
JUMP = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0, 0.0, 0.0]])
SMALL = {"limits": limits, "start": REST}

call(core.first_excess, 1, **SMALL, samples=JUMP)  # the order of the difference
call(core.with_rates, REST, times=np.zeros(1), positions=REST[:, :2], start=REST, period=1.0)
call(core.brake, np.zeros((0, 6)), **SMALL)
call(core.bridge_to_start, SLOW[1:1], **SMALL, target=SLOW, most_steps=10)
call(core.bridge_on_time, SLOW[1:1], **SMALL, target=SLOW, most_steps=10)
call(core.slowed, SLOW, limits=limits, path=SLOW, most_samples=60)
call(core.eased, SLOW[1:], **SMALL, path=SLOW, rate=1.0)
call(core.stopped, SLOW, **SMALL, path=SLOW)
scene = make(
    core.GuardedScene, model=model, obstacles=[], growth=[], margin=0.0, self_collision_margin=0.0
)
call(core.first_contact, None, scene=scene, start=np.zeros(2), samples=SLOW, age=0.0)

# Calls of what learns from demonstrations: alignment, Gaussians, basis functions.
X, Y = np.tile([1.0, 0.0, 0.0], (2, 1)), np.tile([0.0, 1.0, 0.0], (2, 1))

call(core.dtw_distance, 2.0, a=X, b=0 * X, band=2)
call(core.dtw_path, [[0, 0], [1, 1]], a=np.vstack([X[0], Y[0]]), b=np.vstack([X[0], Y[0]]))
call(core.frechet_distance, 1.0, a=X, b=0 * X, band=2)
CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
MOVED = np.array([3.0, 4.0])
call(core.rms_apart, 5.0 * (1 - np.eye(2)), curves=np.stack([CORNER, CORNER + MOVED]))
call(core.arc_lengths, [0.0, 1.0, 2.0], points=CORNER)
call(core.by_arc_length, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], points=CORNER, count=3)
call(core.all_finite, True, values=np.arange(3.0))
call(core.is_covariance, True, matrix=np.eye(2))
GAUSSIAN = {"centres": BREAKS, "sharpness": 2.0, "periodic": False}
call(core.normalised_basis, [[0.5, 0.5]], phases=HALF, **GAUSSIAN, order=0)
MOTIONS = {"weights": np.array([[2.0, 4.0, 1.0, 3.0]]), "most": 1, "threads": 1}  # two curves each
call(
    core.curves_over,
    [[[[[3.0, 2.0]], [[-2.0, -2.0]]]]],
    basis=np.array([[0.5, 0.5], [1.0, -1.0]]),
    bases=2,
    **MOTIONS,
)
OVER = {"phases": HALF, "factors": np.ones(1), **GAUSSIAN}
call(core.curves_over_basis, [[[[[3.0, 2.0]]]]], **OVER, **MOTIONS)
call(core.product, [[2.0, 3.0]], left=np.ones((1, 2)), right=np.array([[1.0, 1.0], [1.0, 2.0]]))
call(core.solve_definite, [[0.5], [2.0]], matrix=2.0 * np.eye(2), right=np.array([[1.0], [4.0]]))
WALLED = {"walls": np.eye(2), "limits": np.full(2, 5.0), "start": np.ones(2)}
AHEAD = np.array([[0.0, 2.0]])
call(core.sample_truncated_gaussian, AHEAD, velocities=AHEAD, **WALLED)
call(
    core.condition_weights,
    False,
    mean=np.zeros(4),
    covariance=np.eye(4),
    basis=np.array([[1.0, 0.0]]),
    columns=np.array([0, 1]),
    values=np.ones((1, 2)),
    noise=np.zeros((2, 2)),
    scale=np.ones(2),
    least=1e-9,
)
call(
    core.condition_at,
    [0.5, 0.5],
    mean=np.zeros(2),
    covariance=np.eye(2),
    **GAUSSIAN,
    scale=np.ones(1),
    duration=2.0,
    time=1.0,
    position=np.ones(1),
    noise=HALF[:, None],
    least=1e-9,
)
