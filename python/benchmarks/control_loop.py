"""Times of single steps in a control loop.

Each loop makes a million steps of 1 ms, one after the other, and each step is timed by the wall
clock, with Python's garbage collection on, as in a plain program. Steps that take long are looked
at: the system may have run another process meanwhile (`getrusage` counts that), Python may have
collected garbage (its callbacks tell), or the step itself may be slow. The table prints all three.
A second table has steps of exported skills in C++, which read the clock as often.
"""

from __future__ import annotations

import gc
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import leadthrough as lt

_ROOT = Path(__file__).parents[2]
STEPS = 1_000_000
DT = 1e-3  # s
PERIOD = 1000  # steps, after which a motion begins again and a target turns
START = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
_LONG = 20_000  # ns; longer steps are looked at
_WARM = 2000
Step = Callable[[int], Any]


@dataclass(frozen=True)
class Row:
    """Wall times of the steps of one loop, us.

    Attributes:
        name: of the loop.
        steps: how many.
        median: of all steps.
        high: that 99.9 % do not exceed.
        worst: of all steps.
        interrupted: steps of more than 20 us in which the system ran something else.
        worst_alone: of the steps that were not interrupted.
        collections: of garbage.
        worst_collection: the longest of them.
    """

    name: str
    steps: int
    median: float
    high: float
    worst: float
    interrupted: int
    worst_alone: float
    collections: int
    worst_collection: float


def run(out: Path, *, steps: int) -> None:
    """Prints the table and writes it to control_loop.json.

    Args:
        out: folder to write to.
        steps: of each loop.
    """
    rows = []
    print("| step of | median | 99.9 % | worst | interrupted | worst of the others | collections |")
    print("|---|---|---|---|---|---|---|")
    for name, step in loops():
        rows.append(measured(name, step, steps))
        print(_text(rows[-1]), flush=True)
    out.mkdir(parents=True, exist_ok=True)
    (out / "control_loop.json").write_text(json.dumps([asdict(row) for row in rows], indent=2))
    _print_cpp_loops(out / "exported")


def _print_cpp_loops(folder: Path) -> None:
    """Prints the rows of the loops in C++, of exported skills, a million steps each."""
    build = _ROOT / "build" / "core"
    target = ["--target", "leadthrough_time_steps"]
    run = partial(subprocess.run, check=True, stdout=subprocess.DEVNULL)
    run(["cmake", build, "-DLEADTHROUGH_TESTS=ON"])
    run(["cmake", "--build", build, *target])
    run([sys.executable, _ROOT / "tests" / "cpp" / "leadthrough" / "export_skills.py", folder])
    panda = _ROOT / "robots" / "panda" / "panda.urdf"
    command = [build / "tests" / "cpp" / "leadthrough_time_steps", folder, panda]
    print("\n| step in C++ of | median | 99.9 % | worst |\n|---|---|---|---|", flush=True)
    subprocess.run(command, check=True)


def loops() -> Iterator[tuple[str, Step]]:
    """The loops by name: functions that make step number i."""
    arm = lt.Arm.load("panda")
    yield "`DMP.step`, 7 joints", _motion(lt.DMP().fit([_joints()]))
    yield "`DMP.step`, reading the pose", _motion(lt.DMP().fit([_poses(arm)]), "pose")
    yield "`DifferentialIk.step`, Panda", _differential(arm)
    yield "`JerkFilter.step`, 7 joints", _filtered(arm)
    yield "`FastMarchingSkill.policy`, 3-D", _policy()


def measured(name: str, step: Step, steps: int) -> Row:
    """The row of a loop."""
    for i in range(_WARM):
        step(i)
    times = np.empty(steps, dtype=np.int64)
    interrupted, alone, pauses = 0, 0, list[int]()
    began = 0

    def collecting(phase: str, _info: dict[str, int]) -> None:
        nonlocal began
        if phase == "start":
            began = clock()
        else:
            pauses.append(clock() - began)

    clock = time.perf_counter_ns
    gc.collect()
    gc.callbacks.append(collecting)
    seen = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
    for i in range(steps):
        start = clock()
        step(i)
        taken = clock() - start
        times[i] = taken
        if taken > _LONG:
            switches = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
            if switches != seen:
                interrupted, seen = interrupted + 1, switches
                continue
        alone = max(alone, taken)
    gc.callbacks.remove(collecting)
    median, high, worst = np.percentile(times, [50.0, 99.9, 100.0]) / 1e3
    return Row(
        name, steps, float(median), float(high), float(worst), interrupted, alone / 1e3,
        len(pauses), max(pauses, default=0) / 1e3,
    )  # fmt: skip


def _text(row: Row) -> str:
    collections = f"{row.collections}, {row.worst_collection:.0f}" if row.collections else "none"
    median, high = (f"{float(f'{each:.2g}'):g}" for each in (row.median, row.high))
    return (
        f"| {row.name} | {median} | {high} | {row.worst:.0f} | {row.interrupted} "
        f"| {row.worst_alone:.0f} | {collections} |"
    )


def _rise() -> Any:
    return lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 201))[:, None]


def _joints() -> lt.Demonstration[Any]:
    turn = [0.5, 0.3, -0.4, 0.2, 0.6, -0.3, 0.8]
    names = lt.Arm.load("panda").joint_names
    times = np.linspace(0.0, 1.0, 201)
    return lt.Demonstration(
        lt.JointTrajectory(times, START + _rise() * turn, joint_names=names), "joints"
    )


def _poses(arm: lt.Arm) -> lt.Demonstration[Any]:
    times = np.linspace(0.0, 1.0, 201)
    return lt.Demonstration(
        lt.PoseTrajectory(times, *arm.forward_kinematics(START + _rise() * 0.2))
    )


def _motion(skill: Any, read: str = "position") -> Step:
    state = skill.begin()

    def step(i: int) -> Any:
        nonlocal state
        state = skill.step(state, DT) if i % PERIOD else skill.begin()
        return getattr(state, read)

    return step


def _differential(arm: lt.Arm) -> Step:
    position, orientation = arm.forward_kinematics(START)
    phase = np.linspace(0.0, 2.0 * np.pi, PERIOD, endpoint=False)
    circle = position + 0.03 * np.column_stack([np.cos(phase) - 1.0, np.sin(phase), 0.0 * phase])
    ik = lt.DifferentialIk(arm, dt=DT, gain=20.0, posture=START)
    state = ik.start(START)

    def step(i: int) -> Any:
        nonlocal state
        state = ik.step(state, circle[i % PERIOD], orientation)

    return step


def _filtered(arm: lt.Arm) -> Step:
    limits = arm.limits
    made = lt.trajectories.JerkFilter(limits.velocity, limits.acceleration, limits.jerk)
    state = lt.trajectories.FilterState.at_rest(START)
    targets = [START + 0.3, START - 0.2]

    def step(i: int) -> Any:
        nonlocal state
        state = made.step(state, targets[i // PERIOD % 2], DT)

    return step


def _policy() -> Step:
    s = _rise()
    shown = [
        lt.Trajectory(
            np.linspace(0.0, 2.0, 201),
            s * [0.6, 0.0, 0.0] + np.hstack([0.0 * s, 0.1 * np.sin(3.0 * s), 0.02 * k * s]),
        )
        for k in range(3)
    ]
    skill = lt.FastMarching().fit(shown)
    begin = shown[0].positions[0]
    place = begin

    def step(i: int) -> Any:
        nonlocal place
        place = place + DT * skill.policy(place) if i % PERIOD else begin

    return step
