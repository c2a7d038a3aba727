"""Formulas of Lauretti et al. 2023 as printed, against what they stand for.

- `of_maps`: the exponential and logarithm, eqs. A13, A14, A17 and A18, and eq. 9,
  which is to take a turn off.
- `of_kernels`: motions replayed with kernels evenly spaced in the phase (A.1) and in time. The
  primitive is that of eqs. A1 to A7, integrated here, of positions, with 50 kernels.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory
from leadthrough_studies import intervals
from leadthrough_studies.agriculture.skills import show
from leadthrough_studies.agriculture.tasks import TASKS, load_arm
from leadthrough_studies.study import Row, selected

ANGLES = (1.0, 90.0, 170.0, 180.0)  # degrees
SPACINGS = ("phase", "time")
_AXIS = np.array([2.0, 3.0, 6.0]) / 7.0
_ALPHA, _BETA, _DECAY = 25.0, 6.25, -np.log(0.01)  # x ends at 0.01
_KERNELS, _OVERLAP = 50, 0.4  # the value of a kernel at its neighbour's centre, as in `DMP`
_STEPS = 1000
_BACK_AT_START = 1e-3  # m: the paper's force is zero for a channel that ends where it began


def of_maps(*, angle_deg: float) -> list[Row]:
    """A row for each formula: its error for a rotation, as a fraction of the angle."""
    vector = np.radians(angle_deg) * _AXIS
    true = Rotation.from_rotvec(vector)
    found = {
        "A13": Rotation.from_matrix(_a13(vector)).as_rotvec(),
        "A14": _a14(true.as_matrix()),
        "A17": Rotation.from_quat(_a17(vector), scalar_first=True).as_rotvec(),
        "A18": _a18(true.as_quat(scalar_first=True)),
        "eq. 9": vector * (1.0 - 2.0 * np.pi) / np.linalg.norm(vector),
    }
    turned = vector * (1.0 - 2.0 * np.pi / np.linalg.norm(vector))
    wanted = {"eq. 9": turned}
    size = np.radians(angle_deg)
    return [
        {"study": "maps", "formula": name, "angle_deg": angle_deg}
        | {"error": float(np.linalg.norm(value - wanted.get(name, vector)) / size)}
        for name, value in found.items()
    ]


def _a13(vector: Float64Array) -> Float64Array:
    x, y, z = vector
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.linalg.norm(vector)
    sine, cosine = np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2
    return np.asarray(np.eye(3) + sine * skew + cosine * skew @ skew)


def _a14(matrix: Float64Array) -> Float64Array:
    angle = np.arccos(np.clip((np.trace(matrix) - 1.0) / 2.0, -1.0, 1.0))
    skew = angle / (2.0 * np.sin(angle)) * (matrix - matrix.T)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def _a17(vector: Float64Array) -> Float64Array:
    angle = np.linalg.norm(vector)
    return np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * vector / angle)


def _a18(q: Float64Array) -> Float64Array:
    angle = 2.0 * np.arctan2(np.linalg.norm(q[1:]), q[0])
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(angle * q[1:] / q[0])


def of_kernels(*, tasks: list[str], repetitions: list[int], seed: int) -> list[Row]:
    """A row for each spacing of the kernels: mean normalised position error of a person's motions.

    Motions of which a channel ends where it began are left out.
    """
    arm = load_arm()
    shown = [
        show(arm, task, subtask, i, seed=seed).poses
        for task in tasks
        for subtask in TASKS[task]
        for i in repetitions
    ]
    moved = [each for each in shown if _moves(each)]
    return [
        {"study": "kernels", "seed": seed, "spacing": spacing, "motions": len(moved)}
        | {"npe": float(np.mean([replay_error(each, spacing) for each in moved]))}
        for spacing in SPACINGS
    ]


def _moves(motion: PoseTrajectory) -> bool:
    ends = motion.positions[[0, -1]]
    return bool((np.abs(ends[1] - ends[0]) > _BACK_AT_START).all())


def replay_error(motion: PoseTrajectory, spacing: str) -> float:
    """The paper's NPE of a motion's positions, learned and replayed by eqs. A1 to A7.

    Args:
        motion: the recording, of which each channel ends elsewhere than it began.
        spacing: of SPACINGS.
    """
    u = np.linspace(0.0, 1.0, _STEPS + 1)
    at = motion.times[0] + u * motion.duration
    y = np.column_stack([np.interp(at, motion.times, column) for column in motion.positions.T])
    force = _force(u, y, _centres(spacing))
    away = np.linalg.norm(_integrated(y, force) - y, axis=1)
    return float(away.mean() / np.linalg.norm(y[-1] - y[0]))


def _centres(spacing: str) -> Float64Array:
    even = np.linspace(0.0, 1.0, _KERNELS)
    return np.asarray(np.exp(-_DECAY * even) if spacing == "time" else 1.0 - even)


def _force(u: Float64Array, y: Float64Array, centres: Float64Array) -> Float64Array:
    """The force (n, 3) that locally weighted regression finds, eqs. A2 to A7."""
    slopes = np.gradient(y, u, axis=0)
    wanted = np.gradient(slopes, u, axis=0) - _ALPHA * (_BETA * (y[-1] - y) - slopes)
    x = np.exp(-_DECAY * u)[:, None]
    gaps = -np.diff(centres)
    sharpness = -np.log(_OVERLAP) / np.append(gaps, gaps[-1]) ** 2
    psi = np.exp(-sharpness * (x - centres) ** 2)
    scale = y[-1] - y[0]
    weights = psi.T @ (x * wanted) / (psi.T @ x**2) / scale
    return np.asarray(psi @ weights / psi.sum(axis=1, keepdims=True) * x * scale)


def _integrated(y: Float64Array, force: Float64Array) -> Float64Array:
    """The motion (n, 3) of eq. A1 from rest, by semi-implicit steps."""
    step = 1.0 / _STEPS
    made, slope = np.empty_like(y), np.zeros(y.shape[1])
    made[0] = y[0]
    for k in range(_STEPS):
        slope = slope + step * (_ALPHA * (_BETA * (y[-1] - made[k]) - slope) + force[k])
        made[k + 1] = made[k] + step * slope
    return made


def kernels_table(rows: list[Row]) -> list[Row]:
    """Medians over persons by the spacing of the kernels."""
    return [
        {"spacing": spacing, "persons": len(own), "motions": sum(row["motions"] for row in own)}
        | {f"npe_{name}": x for name, x in intervals.median([row["npe"] for row in own]).items()}
        for spacing in SPACINGS
        if (own := selected(rows, spacing=spacing))
    ]
