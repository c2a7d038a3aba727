"""Map of the positions that an arm reaches, and base poses from which it can run a motion."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, rotations
from leadthrough.arm import Arm, IkOptions, check_arm
from leadthrough.check import Float64Array, IkFailure, InvalidInput, ShortRepr
from leadthrough.io import npz
from leadthrough.io.files import StrPath
from leadthrough.models import Skill, TargetRegion
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.tasks import Execution, Outcome, Row, Store, Task, pickled

_POSES = 2000  # of a task: a fraction of a second
_MAX_POSITIONS = 10_000_000
_DRAWN = 4000  # configurations from which the volume is taken where none is given


@dataclass(frozen=True, eq=False)
class ReachMap(ShortRepr):
    """Poses that an arm reaches on a grid of positions.

    Attributes:
        origin: (3,) of the first place, m in the base frame.
        spacing: between neighbouring places, m.
        orientations: (k, 4) w, x, y, z that were tried at each place.
        fraction: (nx, ny, nz) of the orientations that are reached clear of the arm itself and of
            obstacles, 0 to 1.
        manipulability: (nx, ny, nz), the largest of the solutions, as `Arm.manipulability`; 0 where
            nothing is reached.
    """

    origin: Float64Array
    spacing: float
    orientations: Float64Array
    fraction: Float64Array
    manipulability: Float64Array

    @property
    def volume(self) -> float:
        """Volume of the positions reached in any orientation, m^3."""
        return float((self.fraction > 0.0).sum()) * self.spacing**3

    @property
    def axes(self) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Coordinates of the positions along x, y and z, m."""
        x, y, z = (
            start + self.spacing * np.arange(count)
            for start, count in zip(self.origin, self.fraction.shape, strict=True)
        )
        return x, y, z

    def save(self, path: StrPath) -> None:
        """Writes the arrays by their names to a .npz file.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        npz.write_compressed(path, vars(self) | {"spacing": np.array(self.spacing)})


def reach_map(
    arm: Arm,
    scene: SceneLike = (),
    *,
    volume: TargetRegion | None = None,
    spacing: float = 0.1,
    orientations: int = 12,
    seed: int = 0,
    execution: Execution | None = None,
) -> ReachMap:
    """Positions of an arm's tip: the fraction of reached orientations and the manipulability.

    Each pose is solved by inverse kinematics; it is reached if a solution inside the joint limits
    keeps the scene's margins. The search is random: a pose counted as out of
    reach may, rarely, have a solution.

    Args:
        arm: with collision shapes.
        scene: obstacles in the base frame, and the margins.
        volume: corners of the grid, m in the base frame; by default the arm's whole reach.
        spacing: between neighbouring places, m, > 0.
        orientations: number of orientations at each place, spread evenly over all, >= 1.
        seed: of the random number generator.
        execution: process or cluster of the tasks, and folder of finished ones; by default here.

    Raises:
        InvalidInput: if the grid has too many places.
        InvalidRobot: if the robot has no collision geometry.
        MissingDependency: for a Dask cluster, if the extra `dask` is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    check_arm(arm)
    step = check.number(spacing, "spacing", above=0.0)
    number = check.integer(seed, "seed", at_least=0)
    turned = spread_orientations(check.integer(orientations, "orientations", at_least=1))
    corners = _whole_reach(arm, step) if volume is None else volume
    if len(corners.lower) != 3:
        raise InvalidInput(f"volume: expected 3 coordinates, got {len(corners.lower)}")
    counts = (np.floor((corners.upper - corners.lower) / step + 1e-9) + 1).astype(int)
    if counts.prod() > _MAX_POSITIONS:
        raise InvalidInput(
            f"spacing: expected at most {_MAX_POSITIONS:,} places, got {counts.prod():,}; raise it"
        )
    axes = [low + step * np.arange(n) for low, n in zip(corners.lower, counts, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    how = Execution() if execution is None else execution
    with how.folder() as folder:
        common = Workspace(arm, as_scene(scene), turned, places)
        file = pickled(common, folder / "workspace.pickle")
        each = max(1, _POSES // len(turned))
        todo = [
            Task(
                reach_rows,
                {"first": first, "count": min(each, len(places) - first), "seed": number},
                {"workspace": file},
            )
            for first in range(0, len(places), each)
        ]
        store = Store(folder / "cache")
        found = _collected(how.outcomes(todo, store, folder, "mapping"), todo, store)
    fraction, measure = (column.reshape(counts) for column in found.T)
    return ReachMap(corners.lower, step, turned, fraction / len(turned), measure)


def _collected(outcomes: Iterator[Outcome], todo: Sequence[Task], store: Store) -> Float64Array:
    """The number of orientations and the manipulability (n, 2) of all places."""
    for each in outcomes:
        if each.failure is not None:
            raise InvalidInput(
                f"arm: a task failed: {each.failure['error']}: {each.failure['message']}"
            )
    rows = (row for task in todo for row in store.rows(task.key) or ())
    return np.array([[row["reached"], row["manipulability"]] for row in rows], dtype=np.float64)


def _whole_reach(arm: Arm, spacing: float) -> TargetRegion:
    """The box around the tips of random configurations, on multiples of the spacing."""
    rng = np.random.default_rng(0)
    shape = (_DRAWN, len(arm.joint_names))
    positions, _ = arm.forward_kinematics(rng.uniform(*ranges(arm), shape))
    lower = np.floor(positions.min(axis=0) / spacing) * spacing
    return TargetRegion(lower, np.ceil(positions.max(axis=0) / spacing) * spacing)


# Solutions of a pose that are looked at: where the first touches, another may be clear.
_TRIES = 3
# Of each search; most poses that can be reached are by the first few.
_RESTARTS = 12
_TOLERANCE = 1e-4  # m and rad


@dataclass(frozen=True, eq=False)
class Workspace:
    """Data common to all tasks of a map."""

    arm: Arm  # that reaches
    scene: Scene  # to be clear of
    orientations: Float64Array  # (k, 4) that are tried at each place
    places: Float64Array  # (n, 3) in m, base frame


def ranges(arm: Arm) -> tuple[Float64Array, Float64Array]:
    """Lowest and highest joints; of a joint that turns without end, a whole turn."""
    lower, upper = arm.limits.lower, arm.limits.upper
    return np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)


def reached(
    arm: Arm,
    positions: Float64Array,
    orientations: Float64Array,
    scene: Scene,
    seed: int,
) -> tuple[NDArray[np.bool_], Float64Array]:
    """Collision-free reached poses (m,) as a mask, and the joints there (m, joints)."""
    found = np.zeros(len(positions), dtype=bool)
    joints = np.full((len(positions), len(arm.joint_names)), np.nan)
    rng = np.random.default_rng(seed)
    lower, upper = ranges(arm)
    left = np.arange(len(positions))
    for attempt in range(_TRIES):
        if not len(left):
            break
        middle = 0.5 * (lower + upper)
        starts = middle if attempt == 0 else rng.uniform(lower, upper, (len(left), len(lower)))
        solved = arm.inverse_kinematics_batch(
            positions[left],
            orientations[left],
            q0=starts,
            options=IkOptions(
                position_tolerance=_TOLERANCE,
                orientation_tolerance=_TOLERANCE,
                max_restarts=_RESTARTS,
            ),
            seed=seed + attempt,
        )
        good = solved.success.copy()
        if good.any():
            good[good] = arm.is_clear(solved.q[good], scene)
        found[left[good]] = True
        joints[left[good]] = solved.q[good]
        left = left[solved.success & ~good]
    return found, joints


def reach_rows(*, first: int, count: int, seed: int, workspace: Path) -> list[Row]:
    """A row for each place: the number of orientations reached, and the best manipulability."""
    common: Workspace = pickle.loads(workspace.read_bytes())
    places = common.places[first : first + count]
    each = len(common.orientations)
    found, joints = reached(
        common.arm,
        places.repeat(each, axis=0),
        np.tile(common.orientations, (len(places), 1)),
        common.scene,
        seed + first,
    )
    measure = np.zeros(len(found))
    if found.any():
        measure[found] = common.arm.manipulability(joints[found])
    return [
        {"reached": int(own.sum()), "manipulability": float(best)}
        for own, best in zip(
            found.reshape(-1, each), measure.reshape(-1, each).max(axis=1), strict=True
        )
    ]


_PSI = 1.533751168755204288118041  # root of x^4 = x + 4


def spread_orientations(count: int) -> Float64Array:
    """Quaternions (count, 4) w, x, y, z that are spread evenly over all rotations.

    Args:
        count: their number, >= 1.
    """
    number = check.integer(count, "count", at_least=1)
    at = np.arange(number) + 0.5
    fraction = at / number
    near, far = np.sqrt(fraction), np.sqrt(1.0 - fraction)
    alpha, beta = 2.0 * np.pi * at / np.sqrt(2.0), 2.0 * np.pi * at / _PSI
    parts = (far * np.cos(beta), near * np.sin(alpha), near * np.cos(alpha), far * np.sin(beta))
    return np.column_stack(parts)


_SAMPLES = 25  # of the motion, that are looked at from each place
_FOLLOWED = 20  # of the best places, which are tried until one is found from which it is run


@dataclass(frozen=True, eq=False)
class Placement(ShortRepr):
    """Fraction of a motion that an arm reaches, by base pose.

    Attributes:
        bases: (n, 4) places of the base, x, y, z in m and the yaw in rad, in the motion's frame.
        fraction: (n,) of the motion's samples that are reached from there.
        manipulability: (n,) the smallest along the motion; 0 where a sample is out of reach.
        best: (4,) the place with the largest one from which the arm follows the whole motion; None
            if there is none.
        joints: of the arm along the motion from there; None likewise.
    """

    bases: Float64Array
    fraction: Float64Array
    manipulability: Float64Array
    best: Float64Array | None
    joints: JointTrajectory | None


def place_base(
    motion: Skill[Motion] | PoseTrajectory,
    arm: Arm,
    *,
    area: TargetRegion,
    spacing: float = 0.1,
    yaws: int = 8,
    seed: int = 0,
) -> Placement:
    """The base pose from which an arm runs a motion of poses with the best manipulability.

    Args:
        motion: poses, or a skill of poses, whose own motion is taken; in a frame that stays.
        arm: with collision shapes.
        area: corners of where the base may stand, x, y and z, m in the motion's frame.
        spacing: between neighbouring places, m, > 0.
        yaws: number of directions that the base faces, evenly spread, >= 1.
        seed: of the random number generator.

    Raises:
        InvalidInput: if the motion is not of poses.
        InvalidRobot: if the robot has no collision geometry.
    """
    poses = motion if isinstance(motion, PoseTrajectory) else motion.generate()
    if not isinstance(poses, PoseTrajectory):
        raise InvalidInput(f"motion: expected poses, got {type(poses).__name__}")
    if len(area.lower) != 3:
        raise InvalidInput(f"area: expected 3 coordinates, got {len(area.lower)}")
    bases = _bases(area, check.number(spacing, "spacing", above=0.0), yaws)
    some = np.linspace(0, len(poses) - 1, min(_SAMPLES, len(poses))).round().astype(int)
    seen = [_seen_from(base, poses) for base in bases]
    positions = np.concatenate([each.positions[some] for each in seen])
    turned = np.concatenate([each.orientations[some] for each in seen])
    found, joints = reached(
        arm, positions, turned, Scene(), check.integer(seed, "seed", at_least=0)
    )
    measure = np.zeros(len(found))
    if found.any():
        measure[found] = arm.manipulability(joints[found])
    fraction = found.reshape(len(bases), -1).mean(axis=1)
    least = measure.reshape(len(bases), -1).min(axis=1)
    for i in np.argsort(-least, kind="stable")[:_FOLLOWED]:
        if least[i] <= 0.0:
            break
        try:
            followed = arm.follow(seen[i], q0=joints[i * len(some)])
        except IkFailure:
            continue
        if arm.check(followed).ok:
            return Placement(bases, fraction, least, bases[i], followed)
    return Placement(bases, fraction, least, None, None)


def _bases(area: TargetRegion, spacing: float, yaws: int) -> Float64Array:
    """All places of a grid with all yaws, (n, 4)."""
    axes = [
        low + spacing * np.arange(int(np.floor((high - low) / spacing + 1e-9)) + 1)
        for low, high in zip(area.lower, area.upper, strict=True)
    ]
    count = check.integer(yaws, "yaws", at_least=1)
    axes.append(2.0 * np.pi * np.arange(count) / count)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 4)


def _seen_from(base: Float64Array, poses: PoseTrajectory) -> PoseTrajectory:
    """The motion in the frame of a base that stands at (x, y, z) and faces a yaw."""
    turn = rotations.exp(np.array([[0.0, 0.0, -base[3]]]))
    matrix = rotations.to_matrix(turn)[0]
    return PoseTrajectory(
        poses.times,
        (poses.positions - base[:3]) @ matrix.T,
        rotations.compose(turn.repeat(len(poses), axis=0), poses.orientations),
    )
