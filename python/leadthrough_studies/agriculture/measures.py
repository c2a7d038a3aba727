"""Errors of a generated motion of the tool against a recorded one.

Source: Lauretti et al. 2023, eqs. 10 to 12. They normalise by the distance from start to end, which
grows without bound for a motion that returns to its start, such as pouring. So each error is also
given as a fraction of the distance covered. The paper calls a motion successful if "no singularity
or discontinuity issues occur". Here a motion succeeds if the tool never turns faster than the wrist
can, stays within 30 degrees of the recording and ends within 2 degrees of it.
"""

from __future__ import annotations

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, PoseTrajectory, normalised_times
from leadthrough.preprocess import align_by_time_warping
from leadthrough_studies.study import Row

# Sum of the velocity limits of a TIAGo's last three joints: 1.95 + 1.76 + 1.76 rad/s.
FASTEST = 313.0  # degrees/s
FARTHEST = 30.0  # degrees
END_ERROR = 2.0  # degrees
_BACK_AT_START = 1e-3  # m or rad: below this, start and end coincide
_SPAN = 0.1  # s; over shorter spans, tremor and encoder steps dominate the distance covered


def judged(made: PoseTrajectory, recorded: PoseTrajectory) -> Row:
    """Errors of a motion against the recording at the same fractions of their durations."""
    wanted = at_phases(recorded, normalised_times(made.times))
    away = np.linalg.norm(made.positions - wanted.positions, axis=1)
    angles = rotations.distance(made.orientations, wanted.orientations)
    coarse = at_phases(recorded, np.linspace(0.0, 1.0, int(recorded.duration / _SPAN) + 1))
    along = np.linalg.norm(np.diff(coarse.positions, axis=0), axis=1).sum()
    net = float(np.linalg.norm(coarse.positions[-1] - coarse.positions[0]))
    net_turn = float(_angles(coarse.orientations[[0, -1]])[0])
    steps = _angles(made.orientations) / np.diff(made.times)
    row = {
        "npe": float(away.mean()) / net if net > _BACK_AT_START else None,
        "noe": float(angles.mean()) / net_turn if net_turn > _BACK_AT_START else None,
        "npe_of_path": float(away.mean() / along),
        "noe_of_angle": float(angles.mean() / _angles(coarse.orientations).sum()),
        "rmse_m": float(np.sqrt((away**2).mean())),
        "mean_deg": float(np.degrees(angles.mean())),
        "largest_deg": float(np.degrees(angles.max())),
        "end_deg": float(np.degrees(angles[-1])),
        "fastest_deg_s": float(np.degrees(steps.max())),
        "turned_deg": float(np.degrees(_angles(coarse.orientations).sum())),
        "farthest_from_goal_deg": float(np.degrees(_from_goal(coarse).max())),
    }
    return row | {"succeeded": int(_succeeded(row))}


def gaps(made: PoseTrajectory, shown: PoseTrajectory) -> Row:
    """Mean and final distance of a motion from a demonstrated one, after alignment in time.

    The motions are aligned by time warping, because a person never moves with the same timing
    twice.

    Args:
        made: the generated motion.
        shown: the demonstrated motion.
    """
    pair = [Demonstration(motion) for motion in (shown, made)]
    wanted, came = (each.motion for each in align_by_time_warping(pair, reference=0))
    assert isinstance(wanted, PoseTrajectory)
    assert isinstance(came, PoseTrajectory)
    away = np.linalg.norm(came.positions - wanted.positions, axis=1)
    turned = np.degrees(rotations.distance(came.orientations, wanted.orientations))
    return {
        "mean_m": float(away.mean()),
        "mean_deg": float(turned.mean()),
        "end_m": float(away[-1]),
        "end_deg": float(turned[-1]),
    }


def at_phases(motion: PoseTrajectory, phases: Float64Array) -> PoseTrajectory:
    """The motion at fractions (n,) of its duration."""
    at = np.clip(motion.times[0] + phases * motion.duration, motion.times[0], motion.times[-1])
    columns = [np.interp(at, motion.times, column) for column in motion.positions.T]
    turned = rotations.interpolate(motion.times, motion.orientations, at)
    return PoseTrajectory(at, np.column_stack(columns), turned)


def from_goal(motion: PoseTrajectory) -> Float64Array:
    """The rotations (n, 4) from the last orientation to each orientation."""
    back = rotations.inverse(motion.orientations[-1:])
    return rotations.compose(motion.orientations, np.repeat(back, len(motion.times), axis=0))


def _from_goal(motion: PoseTrajectory) -> Float64Array:
    return np.asarray(np.linalg.norm(rotations.log(from_goal(motion)), axis=1))


def _angles(orientations: Float64Array) -> Float64Array:
    return rotations.distance(orientations[1:], orientations[:-1])


def _succeeded(row: Row) -> bool:
    return bool(
        row["fastest_deg_s"] <= FASTEST
        and row["largest_deg"] <= FARTHEST
        and row["end_deg"] <= END_ERROR
    )
