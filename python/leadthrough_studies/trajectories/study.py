"""Statements of Grioli's lecture notes on trajectories (2023, chapters 2 to 4), measured.

They concern Runge's function on evenly spaced and on Chebyshev nodes, a rotation by Euler angles
and by slerp, the bang-bang law and its discrete-time form in the phase plane, and minimum jerk
compared with other curves through the same points. `interpolation` has more of chapter 2. Of
chapter 4: the weights of a DMP (`forces`), a curve as a sum of Gaussians, the steps of k-means, EM
and the regression (`generalization`). In addition, random splines are retimed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from leadthrough import rotations, trajectories as tr
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.timing import check_limits, retime
from leadthrough_studies.study import Row, Study, Task
from leadthrough_studies.trajectories import forces, generalization, interpolation
from leadthrough_studies.trajectories.report import report

_FINE = 2001
# The example of the notes: a quarter turn about z, then one about the new x.
_TURN = (np.pi / 2, 0.0, np.pi / 2)
_DRAWN = 60  # orientations of a turn that are kept for the figure
# Positions and speeds: at rest, one far enough to cruise; then moving to and from the target.
_STARTS = ((-0.4, 0.0), (0.7, 0.0), (-2.5, 0.0), (-1.0, 0.8), (-0.7, -0.8), (1.5, 0.9))


@dataclass(frozen=True)
class TrajectoriesConfig:
    """The configuration of the study.

    Attributes:
        nodes: numbers of nodes of the polynomials.
        splines: number of random splines to retime.
        period: sampling period of the filters, s.
        seed: seed of the random points and splines.
    """

    nodes: tuple[int, ...] = (5, 9, 13, 17, 21, 25, 29, 33)
    splines: int = 50
    period: float = 0.01
    seed: int = 0


def configure(quick: bool, seed: int) -> TrajectoriesConfig:
    """The full configuration, or one with fewer nodes and splines."""
    if quick:
        return TrajectoriesConfig(nodes=(5, 13, 21), splines=5, seed=seed)
    return TrajectoriesConfig(seed=seed)


def tasks(config: TrajectoriesConfig) -> list[Task]:
    """A task for each statement, and one for each random spline."""
    return [
        *(Task(runge, {"nodes": count}) for count in config.nodes),
        Task(turning, {}),
        *(Task(phase_plane, {"start": x, "speed": v, "period": config.period}) for x, v in _STARTS),
        Task(jerks, {"seed": config.seed}),
        *(Task(retimed, {"seed": config.seed + i}) for i in range(config.splines)),
        *interpolation.tasks(config.nodes, config.seed),
        *forces.tasks(config.seed),
        *generalization.tasks(config.seed),
    ]


def runge(nodes: int) -> list[Row]:
    """The largest error of the polynomial through 1 / (1 + 25 t^2) on [-1, 1]."""
    t = np.linspace(-1.0, 1.0, _FINE)
    errors = {}
    for name, at in (
        ("even", np.linspace(-1.0, 1.0, nodes)),
        ("chebyshev", tr.chebyshev_nodes(nodes)),
    ):
        found = tr.Lagrange(at, 1.0 / (1.0 + 25.0 * at**2)).evaluate(t)[:, 0]
        errors[f"{name}_error"] = float(np.abs(found - 1.0 / (1.0 + 25.0 * t**2)).max())
    return [{"study": "runge", "nodes": nodes, **errors}]


def turning() -> list[Row]:
    """Largest deviation of the rotation axis, rad, with Euler angles and with slerp."""
    t = np.linspace(0.0, 1.0, _FINE)
    by_angles = rotations.from_euler(np.outer(t, _TURN), convention="ZYX")
    slerp = tr.Slerp(t[[0, -1]], by_angles[[0, -1]])
    rows = []
    for name, turned, rates in (
        ("Euler angles", by_angles, rotations.angular_velocity(t, by_angles)),
        ("slerp", slerp.evaluate(t), slerp.evaluate(t, 1)),
    ):
        speeds = np.linalg.norm(rates, axis=1)
        strays = np.arccos(np.clip(rates @ rates[0] / (speeds * speeds[0]), -1.0, 1.0))
        angle = float(trapezoid(speeds, t))
        rows.append(
            {
                "study": "turning",
                "way": name,
                "angle_rad": angle,
                "axis_strays_rad": float(strays.max()),
                "matrices": rotations.to_matrix(turned[:: _FINE // _DRAWN]).tolist(),
            }
        )
    return rows


def phase_plane(start: float, speed: float, period: float) -> list[Row]:
    """The motion to rest at zero by the sampled bang-bang law and by the filter."""
    state = tr.FilterState(np.array([start]), np.array([speed]), np.zeros(1))
    return [
        _descent("bang-bang", state, period, _bang_bang),
        _descent("filter", state, period, tr.TimeOptimalFilter(1.0, 1.0).step),
    ]


def jerks(seed: int) -> list[Row]:
    """Integral of the squared jerk of curves through the same points, at rest at both ends."""
    rng = np.random.default_rng(seed)
    times, points = np.linspace(0.0, 3.0, 5), rng.normal(size=(5, 2))
    t = np.linspace(0.0, 3.0, _FINE)
    ways = {
        "minimum jerk": tr.minimum_jerk_through(times, points),
        "C6 spline": tr.smooth(times, points, continuity=6),
        "stop at every point": None,
    }
    return [
        {"study": "jerks", "way": name, "jerk": _cost(curve, times, points, t)}
        for name, curve in ways.items()
    ]


def retimed(seed: int) -> list[Row]:
    """Durations of a random spline with all, a tenth and a fiftieth of the Panda's jerk limits."""
    limits = Arm.load("panda").limits
    way = np.random.default_rng(seed).uniform(-1.0, 1.0, (12, 7))
    middle = np.clip(way, limits.lower + 0.6, limits.upper - 0.6)
    path = tr.natural_cubic(np.linspace(0.0, 1.0, 12), middle)
    rows = []
    for share in (1.0, 0.1, 0.02):
        assert limits.jerk is not None
        kept = replace(limits, jerk=share * limits.jerk)
        motion = retime(path, kept)
        row = {"study": "retimed", "seed": seed, "jerk_share": share, "duration_s": motion.duration}
        rows.append({**row, "kept": int(check_limits(motion, kept).ok)})
    return rows


def _cost(
    curve: tr.Spline | None, times: Float64Array, points: Float64Array, t: Float64Array
) -> float:
    if curve is not None:
        return float(trapezoid(np.sum(curve.evaluate(t, 3) ** 2, axis=1), t))
    # From rest to rest over a distance L in a time T it is 720 L^2 / T^5.
    lengths = np.sum(np.diff(points, axis=0) ** 2, axis=1)
    return float(np.sum(720.0 * lengths / np.diff(times) ** 5))


def _descent(name: str, state: tr.FilterState, period: float, step: Any) -> Row:
    start = float(state.position[0])
    states = [(start, float(state.velocity[0]))]
    for _ in range(int(6.0 / period)):
        state = step(state, [0.0], period)
        states.append((float(state.position[0]), float(state.velocity[0])))
    accelerations = np.diff([v for _, v in states]) / period
    last = accelerations[-int(1.0 / period) :]
    switches = int(np.sum(np.diff(np.sign(last)) != 0.0))
    overshoot = float(np.max([-np.sign(start) * x for x, _ in states]))
    return {
        "study": "phase plane",
        "law": name,
        "start": start,
        "overshoot": max(overshoot, 0.0),
        "switches_in_the_last_second": switches,
        "states": [list(pair) for pair in states],
    }


def _bang_bang(state: tr.FilterState, target: list[float], period: float) -> tr.FilterState:
    """Grioli 2023, eq. 3.4, with x for the distance from the target."""
    x, v = float(state.position[0] - target[0]), float(state.velocity[0])
    border = -0.5 * v * abs(v)
    side = np.sign(border - x) or -np.sign(v)
    push = 0.0 if side * v >= 1.0 else float(side)
    moved, speed = (
        state.position + period * v + 0.5 * period**2 * push,
        np.array([v + period * push]),
    )
    return tr.FilterState(moved, speed, np.array([push]))


STUDY = Study(configure, tasks, report)
"""The notes' statements."""
