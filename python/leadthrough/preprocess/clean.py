"""Recordings as they come, faults and all, made into demonstrations to learn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, events, rotations
from leadthrough.check import UNIT_LENGTH_TOLERANCE, Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.recording import Recording, recording_of
from leadthrough.motion import Demonstration, Motion
from leadthrough.preprocess.activity import rests
from leadthrough.preprocess.report import CleaningReport, Span
from leadthrough.preprocess.sampling import clipped, sample_evenly, smooth_motion
from leadthrough.preprocess.spikes import spikes

_GAP = 5.0  # median steps without a sample
_LARGEST = 1e100  # no recorder measures more; squares of more overflow
_SHORTEST_QUATERNION = 0.5  # what is shorter was never a rotation
_FIELDS = ("times", "positions", "orientations", "velocities", "accelerations")


def clean(
    recording: Recording | Demonstration,
    *,
    spike_factor: float | None = 5.0,
    longest_gap: float = 0.5,
    pause: float = 0.5,
    longest_pause: float | None = None,
    speed: float = 0.01,
    angular_speed: float = 0.05,
    rate: float | None = None,
    smoothing: float | None = None,
) -> tuple[Demonstration, CleaningReport]:
    """A demonstration without a recording's faults, and the report of what was changed.

    Samples with a missing number and with a quaternion that is no rotation are left out, the others
    sorted by their times, of which each stays once; quaternions get length 1 and one sign. Nothing
    is made up: where samples are left out, there are fewer.
    spike_factor: samples that leap away from their neighbours by so many times what is usual there
    are left out; None leaves them. longest_gap: s without a sample that are let pass, where these
    are five usual steps or more; `cut_at_gaps` cuts there. pause: s below `speed` (m/s, or the unit
    of the positions a second; rad/s of joints) and `angular_speed` (rad/s) that count as a pause.
    longest_pause: s that are left of one; None leaves all. rate: Hz to sample anew at, by
    `sample_evenly`. smoothing: s, the window of `smooth_motion`, which needs an even rate: by
    default that of the median step. All numbers > 0.
    Raises InvalidInput, also where nothing is left or a gap is too long.
    """
    kept = _checked(recording)
    factor = None if spike_factor is None else check.number(spike_factor, "spike_factor", above=0.0)
    read = len(kept.times)
    kept, found = _without_faults(kept, factor)
    gaps = _gaps(kept.times)
    _check_gaps(gaps, check.number(longest_gap, "longest_gap", above=0.0))
    motion = replace(kept, events=clipped(kept.events, kept.times)).motion()
    thresholds = {
        "speed": check.number(speed, "speed", above=0.0),
        "angular_speed": check.number(angular_speed, "angular_speed", above=0.0),
        "pause": check.number(pause, "pause", above=0.0),
    }
    pauses = rests(motion, **thresholds)
    left = motion
    if longest_pause is not None:
        longest = check.number(longest_pause, "longest_pause", above=0.0)
        left = _shortened(motion, pauses, longest)
    result = Demonstration(left, kept.name)
    hertz = rate
    if hertz is None and smoothing is not None and len(left.times) > 1:
        hertz = 1.0 / float(np.median(np.diff(left.times)))
    if hertz is not None:
        result = sample_evenly(result, rate=hertz)
    if smoothing is not None:
        result = smooth_motion(result, window=check.number(smoothing, "smoothing", above=0.0))
    return result, CleaningReport(
        read=read,
        left=len(result.motion.times),
        **found,
        gaps=tuple(gaps),
        pauses=tuple(pauses),
        removed=motion.duration - left.duration,
        rate=hertz,
        smoothing=smoothing,
    )


def cut_at_gaps(
    recording: Recording | Demonstration, *, longest_gap: float = 0.5
) -> list[Recording]:
    """The pieces of a recording between gaps longer than `longest_gap` s, in order.

    Samples without a time are left out, the others sorted. A gap is five usual steps or more.
    Raises InvalidInput.
    """
    whole = _checked(recording)
    longest = check.number(longest_gap, "longest_gap", above=0.0)
    whole = _rows(whole, np.flatnonzero(np.isfinite(whole.times)))
    whole = _rows(whole, np.argsort(whole.times, kind="stable"))
    if len(whole.times) == 0:
        raise InvalidInput("recording: expected samples with times, got none")
    starts = [end for start, end in _gaps(whole.times) if end - start > longest]
    edges = [0, *np.searchsorted(whole.times, starts).tolist(), len(whole.times)]
    pieces = [np.arange(a, b) for a, b in pairwise(edges)]
    return [
        replace(
            piece,
            events=events.within(whole.events, float(piece.times[0]), float(piece.times[-1])),
            name=f"{whole.name} {i}".strip(),
        )
        for i, piece in enumerate((_rows(whole, rows) for rows in pieces), start=1)
    ]


def _checked(recording: Any) -> Recording:
    if isinstance(recording, Demonstration):
        return recording_of(recording)
    if not isinstance(recording, Recording):
        got = type(recording).__name__
        raise InvalidInput(f"recording: expected a Recording or a Demonstration, got {got}")
    return recording


def _rows(recording: Recording, rows: NDArray[Any]) -> Recording:
    parts = {name: getattr(recording, name) for name in _FIELDS}
    return replace(
        recording, **{name: part[rows] for name, part in parts.items() if part is not None}
    )


def _without_faults(recording: Recording, factor: float | None) -> tuple[Recording, dict[str, Any]]:
    """The good samples in order, and what the report says of the others."""
    valid = _valid(recording)
    kept = _rows(recording, np.flatnonzero(valid))
    if len(kept.times) == 0:
        raise InvalidInput("recording: expected samples with all their numbers, got none")
    unordered = int(np.count_nonzero(kept.times < np.maximum.accumulate(kept.times)))
    kept = _rows(kept, np.argsort(kept.times, kind="stable"))
    fresh = np.diff(kept.times, prepend=-np.inf) > 0.0
    kept = _rows(kept, np.flatnonzero(fresh))
    kept, turned = _with_rotations(kept)
    leaps = _leaps(kept, factor)
    return _rows(kept, np.flatnonzero(~leaps)), {
        "invalid": tuple(np.flatnonzero(~valid).tolist()),
        "unordered": unordered,
        "repeated": int(np.count_nonzero(~fresh)),
        "spikes": tuple(kept.times[leaps].tolist()),
        **turned,
    }


def _valid(recording: Recording) -> NDArray[np.bool_]:
    parts = [getattr(recording, name) for name in _FIELDS]
    numbers = np.column_stack([part for part in parts if part is not None])
    valid: NDArray[np.bool_] = (np.abs(numbers) < _LARGEST).all(axis=1)  # which NaN is not
    if recording.orientations is not None:
        lengths = np.linalg.norm(np.where(valid[:, None], recording.orientations, 0.0), axis=1)
        valid &= (lengths > _SHORTEST_QUATERNION) & (lengths < 1.0 / _SHORTEST_QUATERNION)
    return valid


def _with_rotations(recording: Recording) -> tuple[Recording, dict[str, int]]:
    quaternions = recording.orientations
    if quaternions is None:
        return recording, {}
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    unit = quaternions / lengths
    continuous = rotations.align_signs(unit)
    counts = {
        "flipped": int(np.count_nonzero((continuous * unit).sum(axis=1) < 0.0)),
        "unnormalised": int(np.count_nonzero(np.abs(lengths - 1.0) > UNIT_LENGTH_TOLERANCE)),
    }
    return replace(recording, orientations=continuous), counts


def _leaps(recording: Recording, factor: float | None) -> NDArray[np.bool_]:
    if factor is None:
        return np.zeros(len(recording.times), dtype=bool)
    leaps = spikes(recording.positions, factor)
    if recording.orientations is not None:
        leaps |= spikes(recording.orientations, factor)
    return leaps


def _gaps(times: Float64Array) -> list[Span]:
    if len(times) < 2:
        return []
    steps = np.diff(times)
    wide = np.flatnonzero(steps > _GAP * np.median(steps))
    return [(float(times[i]), float(times[i + 1])) for i in wide]


def _check_gaps(gaps: Sequence[Span], longest: float) -> None:
    for start, end in gaps:
        if end - start > longest:
            raise InvalidInput(
                f"recording: no sample from {start:.6g} to {end:.6g} s; cut there with "
                f"preprocess.cut_at_gaps, or allow it by longest_gap, now {longest:g} s"
            )


def _shortened(motion: Motion, pauses: Sequence[Span], longest: float) -> Motion:
    """The motion with no more than the first `longest` s of each pause."""
    kept = np.ones(len(motion.times), dtype=bool)
    old, new = [float(motion.times[0])], [float(motion.times[0])]
    for start, end in pauses:
        excess = end - start - longest
        if excess > 0.0:
            kept &= (motion.times <= start + longest) | (motion.times >= end)
            resumed = new[-1] + (start + longest - old[-1])
            old += [start + longest, end]
            new += [resumed, resumed]
    old.append(float(motion.times[-1]))
    new.append(new[-1] + old[-1] - old[-2])
    times = np.interp(motion.times[kept], old, new)
    fresh = np.diff(times, prepend=-np.inf) > 0.0
    rows = np.flatnonzero(kept)[fresh]
    parts = {
        name: getattr(motion, name)[rows]
        for name in _FIELDS[1:]
        if getattr(motion, name, None) is not None
    }
    happened = clipped(events.moved(motion.events, old, new), times[fresh])
    return replace(motion, times=times[fresh], events=happened, **parts)
