"""Data sets of a skill's motions, for queries drawn at random, and of recorded demonstrations."""

from __future__ import annotations

import base64
import hashlib
import pickle
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from leadthrough import check
from leadthrough.arm import Arm, check_arm
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.io.episode_writers import Episode, EpisodeWriter, Layout, writes_hdf5, writing
from leadthrough.models import Skill, TargetRegion, load_skill
from leadthrough.motion import Demonstration, Event, JointTrajectory, Motion, PoseTrajectory
from leadthrough.preprocess.resample import check_sample_count, several_samples
from leadthrough.shapes import RandomObstacle, SceneLike, as_scene
from leadthrough.tasks import Execution, Outcome, Row, Store, Task, pickled
from leadthrough.timing import check_limits, keep_timing
from leadthrough.validation.validate import PATH_TOLERANCE, Setup, attempt, draw_query, numbers_of

GOAL_POSE = tuple(f"goal_{name}" for name in ("x", "y", "z", "qw", "qx", "qy", "qz"))
_TOGETHER = 50  # motions of a task
_MAX_ROUNDS = 20  # times as many motions as are missing that are tried at most
_OPEN, _CLOSE = {"open", "opens", "opened"}, {"close", "closes", "closed"}  # in events' names


@dataclass(frozen=True, eq=False)
class Augmentation(ShortRepr):
    """A data set that was written, and the motions that are not in it.

    Attributes:
        path: of the data set.
        episodes: number of motions in it.
        frames: number of their samples.
        attempts: number of motions that were tried.
        causes: failures by cause, the most frequent first.
    """

    path: Path
    episodes: int
    frames: int
    attempts: int
    causes: dict[str, int]

    def __str__(self) -> str:
        failed = ", ".join(f"{count} {cause}" for cause, count in self.causes.items())
        told = f"{self.episodes} episodes of {self.attempts} motions, {self.frames} frames"
        return f"{told} in {self.path}" + (f"; left out: {failed}" if failed else "")


def augment(
    skill: Skill[Motion],
    arm: Arm,
    scene: SceneLike = (),
    *,
    episodes: int,
    out: str | Path,
    goals: TargetRegion | None = None,
    starts: TargetRegion | None = None,
    seed: int = 0,
    rate: float = 30.0,
    execution: Execution | None = None,
) -> Augmentation:
    """A data set of the skill's motions on the arm, for queries drawn at random from regions.

    Each motion is planned for the whole arm at the skill's own pace, slowed down only where limits
    require it. Only motions inside all limits and clear between samples are written, by the
    verdicts of `lt.check_limits` and `Arm.check` on the rows as they are written. The others are
    counted. Joints, the tip's poses, the gripper by the skill's events, such as "close gripper" and
    "gripper opened", and the goal and the obstacles' positions are written; images are not made.

    Demonstrations with joints, as `Arm.poses` makes them, keep all motions near the demonstrated
    posture. With poses alone every motion takes the posture that suits its own path: equal starts
    of the tip then have different joints, and a policy trained on them averages over postures.

    Args:
        skill: of poses, of points in 3-D, or of the arm's joints, fitted or loaded.
        scene: of every motion; the position of each `RandomObstacle` is drawn too.
        episodes: number of motions in the data set, >= 1.
        out: folder of a LeRobot data set of version 3, which must not be there yet; or an HDF5
            file, ".hdf5" or ".h5".
        goals: region of the goals; by default the demonstrated goal.
        starts: region of the starts; by default the demonstrated start.
        seed: of the random number generator, >= 0. Equal calls write equal bytes.
        rate: frames per second, > 0.
        execution: process or cluster of the tasks, and folder of finished ones, from which a call
            that was stopped resumes; by default here, and nothing is kept.

    Raises:
        InvalidInput: if nothing is drawn, or the data set cannot be written.
        NoPath: if the arm can run too few of the motions.
        UnsupportedQuery: if the skill takes no start or no goal, and one is asked for.
        MissingDependency: if the extra `lerobot` or `hdf5` is not installed.
    """
    wanted = check.integer(episodes, "episodes", at_least=1)
    check.integer(seed, "seed", at_least=0)
    writes_hdf5(out)
    setup = Setup.of(skill, arm, scene, (starts, goals), rate=rate, controller=None)
    drawn = any(isinstance(each, RandomObstacle) for each in setup.scene.obstacles)
    if goals is None and starts is None and not drawn:
        raise InvalidInput(
            "goals: expected a region of goals or starts, or a RandomObstacle, as all motions are "
            "the same without"
        )
    how = Execution() if execution is None else execution
    with how.folder() as folder:
        todo = _Todo(skill, setup, folder, seed)
        layout = _layout(setup, skill, todo.digest, seed)
        rows = _tried(todo, how, wanted)
        with writing(out, layout) as writer:
            found = _written(writer, rows, wanted, lambda row: _episode(row, layout, arm))
    return replace(found, path=Path(out))


def _written(
    writer: EpisodeWriter, rows: Iterator[Row], wanted: int, episode_of: Callable[[Row], Episode]
) -> Augmentation:
    """Writes the first motions that can be run."""
    causes: Counter[str] = Counter()
    written = frames = 0
    for row in rows:
        if written == wanted:
            continue  # the rest of the tasks
        if row["cause"]:
            causes[row["cause"]] += 1
            continue
        episode = episode_of(row)
        writer.add(episode)
        written += 1
        frames += len(episode.q)
    attempts = written + causes.total()
    if written < wanted:
        raise NoPath(
            f"the arm can run {written} of {attempts} motions, fewer than {wanted} episodes; "
            f"failures: {dict(causes.most_common())}; move or shrink the regions",
            reason="augment",
        )
    return Augmentation(Path(), written, frames, attempts, dict(causes.most_common()))


class _Todo:
    """The tasks of a data set, whose files are in a folder."""

    def __init__(self, skill: Skill[Motion], setup: Setup, folder: Path, seed: int) -> None:
        file = folder / "skill.npz"
        skill.certified(None).save(file)
        self.digest = hashlib.sha256(file.read_bytes()).hexdigest()[:16]
        self.folder, self._seed = folder, seed
        self._files = {"skill": file, "setup": pickled(setup, folder / "setup.pickle")}

    def of(self, first: int, end: int) -> list[Task]:
        """Tasks for motions by their numbers."""
        return [
            Task(
                motions,
                {"first": each, "count": min(_TOGETHER, end - each), "seed": self._seed},
                self._files,
            )
            for each in range(first, end, _TOGETHER)
        ]


def _tried(todo: _Todo, how: Execution, wanted: int) -> Iterator[Row]:
    """Rows of motions in the order of their numbers, until enough of them can be run."""
    store = Store(todo.folder / "cache")
    tried = succeeded = 0
    for _ in range(_MAX_ROUNDS):
        missing = -(-(wanted - succeeded) // _TOGETHER) * _TOGETHER
        tasks = todo.of(tried, tried + missing)
        tried += missing
        before = succeeded
        for rows in _in_order(how.outcomes(tasks, store, todo.folder, "motions"), store):
            succeeded += sum(not row["cause"] for row in rows)
            yield from rows
        if succeeded >= wanted or succeeded == before:
            return


def _in_order(outcomes: Iterator[Outcome], store: Store) -> Iterator[list[Row]]:
    """The rows of tasks in their order, as soon as those before are finished."""
    finished: dict[int, Outcome] = {}
    position = 0
    for each in outcomes:
        finished[each.index] = each
        while position in finished:
            outcome = finished.pop(position)
            if outcome.failure is not None:
                raise InvalidInput(f"motions: a task failed: {outcome.failure['message']}")
            yield store.rows(outcome.key) or []
            position += 1


def _layout(setup: Setup, skill: Skill[Motion], digest: str, seed: int) -> Layout:
    posed = isinstance(skill.generate(), PoseTrajectory)
    target: Sequence[str] = GOAL_POSE if posed else GOAL_POSE[:3]
    if len(setup.goals.lower) != 3:
        target = [f"goal_{name}" for name in setup.arm.joint_names]
    places = [f"obstacle_{i}_{axis}" for i in range(len(setup.scene.obstacles)) for axis in "xyz"]
    events = skill.generate().events
    return Layout(
        setup.arm.robot.name,
        setup.arm.joint_names,
        (*target, *places),
        any(opens(event.name) is not None for event in events),
        setup.rate,
        "reach the goal",
        {
            "skill": digest,
            "model": type(skill).__name__,
            "seed": seed,
            "goals": [setup.goals.lower.tolist(), setup.goals.upper.tolist(), setup.goals.turn],
            "starts": [setup.starts.lower.tolist(), setup.starts.upper.tolist(), setup.starts.turn],
            "margin": setup.scene.margin,
            "images": "none",
        },
    )


def _episode(row: Row, layout: Layout, arm: Arm) -> Episode:
    q, qd = unpacked(row, len(layout.joints))
    positions, orientations = arm.forward_kinematics(q)
    gripper = gripper_states(row["events"], len(q), layout.rate) if layout.has_gripper else None
    return Episode(
        q,
        qd,
        np.hstack([positions, orientations[:, [1, 2, 3, 0]]]),
        gripper,
        np.array(row["objects"]),
        {"query": row["number"], **{k: layout.origin[k] for k in ("seed", "skill")}},
    )


def gripper_states(events: Sequence[Any], count: int, rate: float) -> Float64Array:
    """Whether the gripper is open, 1, or closed, 0, at each frame."""
    changes = [(time, state) for time, name in events if (state := opens(name)) is not None]
    gripper = np.full(count, 1.0 - changes[0][1] if changes else 1.0)
    for time, after in changes:
        gripper[int(np.ceil(time * rate - 1e-9)) :] = after
    return gripper


def opens(name: str) -> float | None:
    """1 for an event at which the gripper opens, 0 where it closes; None for others."""
    words = set(name.lower().split())
    return 1.0 if words & _OPEN else 0.0 if words & _CLOSE else None


def motions(*, first: int, count: int, seed: int, skill: Path, setup: Path) -> list[Row]:
    """A row for each of some queries: the motion, or the reason if the arm cannot run it."""
    learned = load_skill(skill)
    common: Setup = pickle.loads(setup.read_bytes())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unusual queries show in their motions
        return [_row(learned, common, seed, number) for number in range(first, first + count)]


def _row(learned: Skill[Motion], common: Setup, seed: int, number: int) -> Row:
    asked, scene = draw_query(common, seed, number)
    asked = replace(asked, dt=1.0 / common.rate)
    timed, cause, _ = attempt(learned, common, asked, scene, timing=_demonstrated)
    row: Row = {"number": number, "cause": cause}
    if timed is None or cause:
        return row
    assert asked.goal is not None
    places = [shape.position.tolist() for shape in scene.shapes]
    assert timed.velocities is not None
    packed = np.hstack([timed.positions, timed.velocities]).astype(np.float32)
    return row | {
        "objects": [*numbers_of(asked.goal), *(x for place in places for x in place)],
        "events": [[event.time, event.name] for event in timed.events],
        "rows": base64.b64encode(zlib.compress(packed.tobytes())).decode(),
    }


def _demonstrated(joints: JointTrajectory, setup: Setup) -> JointTrajectory:
    """The motion at its own pace, slowed down where limits require it."""
    rows = sampled(joints, setup.rate)
    if check_limits(rows, setup.arm.limits).ok:
        return rows
    return keep_timing(joints, setup.arm.limits, rate=setup.rate, path_tolerance=PATH_TOLERANCE)


def sampled(joints: JointTrajectory, rate: float) -> JointTrajectory:
    """Samples of the spline through a motion, from rest to rest, over a whole number of periods."""
    curve = CubicSpline(joints.times, joints.positions, bc_type="clamped")
    periods = max(1, int(np.ceil(joints.duration * rate - 1e-9)))
    stretch = periods / rate / joints.duration
    own = np.arange(periods + 1) / rate
    times = joints.times[0] + np.minimum(own / stretch, joints.duration)
    events = tuple(
        Event((event.time - float(joints.times[0])) * stretch, event.name)
        for event in joints.events
    )
    q, qd, qdd = (curve(times, order) / stretch**order for order in range(3))
    names = joints.joint_names
    return JointTrajectory(own, q, qd, qdd, joint_names=names, events=events)


def unpacked(row: Row, joints: int) -> tuple[Float64Array, Float64Array]:
    """Positions and velocities (n, joints) of a row that has a motion."""
    packed = zlib.decompress(base64.b64decode(row["rows"]))
    rows = np.frombuffer(packed, np.float32).reshape(-1, 2 * joints).astype(np.float64)
    return np.ascontiguousarray(rows[:, :joints]), rows[:, joints:]


def write_data_set(
    demonstrations: Sequence[Demonstration[JointTrajectory] | JointTrajectory],
    arm: Arm,
    out: str | Path,
    scene: SceneLike = (),
    *,
    rate: float = 50.0,
    task: str = "reach the goal",
) -> Path:
    """The data set of demonstrations, an episode each, that policies can learn from.

    It has the columns of `lt.augment`: joints, the tip's poses, the gripper by events such as
    "close gripper", and the poses of the goal, where a demonstration ends, and the obstacles'
    positions; images are not made.

    Args:
        demonstrations: joint motions of the arm, at least one, each of two samples or more.
        out: folder of a LeRobot data set of version 3, which must not be there yet; or an HDF5
            file, ".hdf5" or ".h5".
        scene: obstacles in the arm's base frame.
        rate: frames per second, > 0. Durations become whole numbers of frames.
        task: of all episodes, in words.

    Raises:
        InvalidInput: if there is no demonstration or one is not of the arm's joints, if the rate
            asks for too many frames, or the data set cannot be written.
        MissingDependency: if the extra `lerobot` or `hdf5` is not installed.
    """
    check_arm(arm)
    frames = check.number(rate, "rate", above=0.0)
    if not isinstance(task, str):
        raise check.refused("task", "words", repr(task))
    if not isinstance(demonstrations, Sequence) or not demonstrations:
        got = type(demonstrations).__name__ if demonstrations else "none"
        raise check.refused("demonstrations", "a sequence of at least one", got)
    given = [several_samples(each) for each in demonstrations]
    motions = [arm.joints_of(each.motion) for each in given]
    for motion in motions:
        check_sample_count(motion.duration, frames)
    places = [shape.position for shape in as_scene(scene).shapes]
    names = [f"obstacle_{i}_{axis}" for i in range(len(places)) for axis in "xyz"]
    grips = any(opens(event.name) is not None for each in motions for event in each.events)
    layout = Layout(
        *(arm.robot.name, arm.joint_names, (*GOAL_POSE, *names), grips, frames, task),
        {"demonstrations": [each.name for each in given], "images": "none"},
    )
    with writing(out, layout) as writer:
        for each, motion in zip(given, motions, strict=True):
            rows = sampled(motion, frames)
            writer.add(_recorded(rows, arm, layout, np.ravel(places), each.name))
    return Path(out)


def _recorded(
    rows: JointTrajectory, arm: Arm, layout: Layout, places: Float64Array, name: str
) -> Episode:
    positions, orientations = arm.forward_kinematics(rows.positions)
    events = [(event.time, event.name) for event in rows.events]
    assert rows.velocities is not None  # of a spline
    return Episode(
        rows.positions,
        rows.velocities,
        np.hstack([positions, orientations[:, [1, 2, 3, 0]]]),
        gripper_states(events, len(rows), layout.rate) if layout.has_gripper else None,
        np.concatenate([positions[-1], orientations[-1], places]),
        {"demonstration": name},
    )
