"""Makes demonstrations of recordings with faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, events, rotations
from leadthrough.check import UNIT_LENGTH_TOLERANCE, Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.recording import Recording, recording_of
from leadthrough.motion import Demonstration, Motion, MotionT, fields_of, rows_of
from leadthrough.preprocess.rate import sample_evenly
from leadthrough.preprocess.report import CleaningReport, Span
from leadthrough.preprocess.rows import chosen
from leadthrough.preprocess.smooth import smoothed_over
from leadthrough.preprocess.spikes import spikes
from leadthrough.rest import rests, standstill, trim

_GAP = 5.0  # median steps without a sample
_MAX_NUMBER = 1e100  # no recorder measures more; squares of more overflow
_MIN_LENGTH = 0.5  # anything shorter, or longer than its inverse, was never a rotation


@overload
def clean(
    recording: Recording,
    *,
    spike_factor: float | None = ...,
    longest_gap: float = ...,
    pause: float = ...,
    longest_pause: float | None = ...,
    rest: float = ...,
    speed: float | None = ...,
    angular_speed: float | None = ...,
    rate: float | None = ...,
    smoothing: float | None = ...,
) -> tuple[Demonstration, CleaningReport]: ...


@overload
def clean(
    recording: Demonstration[MotionT] | MotionT,
    *,
    spike_factor: float | None = ...,
    longest_gap: float = ...,
    pause: float = ...,
    longest_pause: float | None = ...,
    rest: float = ...,
    speed: float | None = ...,
    angular_speed: float | None = ...,
    rate: float | None = ...,
    smoothing: float | None = ...,
) -> tuple[Demonstration[MotionT], CleaningReport]: ...


def clean(
    recording: Recording | Demonstration | Motion,
    *,
    spike_factor: float | None = 5.0,
    longest_gap: float = 0.5,
    pause: float = 0.5,
    longest_pause: float | None = None,
    rest: float = 0.0,
    speed: float | None = None,
    angular_speed: float | None = None,
    rate: float | None = None,
    smoothing: float | None = None,
) -> tuple[Demonstration[Any], CleaningReport]:  # Any: the overloads tell
    """A demonstration without a recording's faults, and a report of every change.

    Samples with a missing number or a quaternion that is no rotation are left out. The others are
    sorted by time, and of equal times the first is kept. Quaternions get length 1 and continuous
    signs. No sample is made up: where some are left out, there are fewer.

    Args:
        recording: with faults; a demonstration or a motion is cleaned as well.
        spike_factor: > 0; samples that jump away from their neighbours by more than this multiple
            of the usual noise there are left out. None keeps them.
        longest_gap: longest time without a sample, > 0, s; times shorter than five usual steps are
            no gap. `cut_at_gaps` cuts a recording with longer ones.
        pause: shortest time of rest that counts as a pause, > 0, s.
        longest_pause: longer pauses are shortened to this, > 0, s; None keeps them.
        rest: s of standing still to keep before and after the motion, >= 0; more is left out, as by
            `trim`. Infinite keeps all of it.
        speed: below half of which the motion rests, > 0, m/s, or the unit of the positions per
            second; rad/s of joints. By default it follows from the recording's noise, as for
            `trim`.
        angular_speed: below half of which poses rest, > 0, rad/s; by default as for `speed`.
        rate: of the new samples that `sample_evenly` makes, > 0, Hz; None keeps the samples.
        smoothing: window of `smooth_motion`, > 0, s, for which the samples are evenly spaced first,
            without a rate at that of the median step. None does not smooth.

    Raises:
        InvalidInput: if an argument is out of bounds, no sample is left, or a gap is too long.
    """
    factor = None if spike_factor is None else check.number(spike_factor, "spike_factor", above=0.0)
    window = None if smoothing is None else check.number(smoothing, "smoothing", above=0.0)
    raw = _as_recording(recording)
    kept, found = _without_faults(raw, factor)
    gaps = _gaps(kept.times)
    _check_gaps(gaps, check.number(longest_gap, "longest_gap", above=0.0))
    motion = replace(kept, events=events.clipped(kept.events, kept.times)).motion()
    pauses = rests(
        motion,
        speed=speed,
        angular_speed=angular_speed,
        pause=check.number(pause, "pause", above=0.0),
    )
    left = motion
    if longest_pause is not None:
        longest = check.number(longest_pause, "longest_pause", above=0.0)
        left = _shortened(motion, pauses, longest)
    moving = trim(
        Demonstration(left, kept.name), rest=rest, speed=speed, angular_speed=angular_speed
    )
    hertz = _rate(moving.motion, rate, window)
    result = _resampled(moving, hertz, window)
    return result, CleaningReport(
        read=len(raw.times),
        left=len(result.motion.times),
        **found,
        gaps=tuple(gaps),
        pauses=tuple(pauses),
        removed=motion.duration - left.duration,
        still=standstill(left, moving.motion),
        rate=hertz,
        smoothing=smoothing,
    )


def cut_at_gaps(
    recording: Recording | Demonstration | Motion, *, longest_gap: float = 0.5
) -> list[Recording]:
    """The pieces of a recording between its gaps, in order, named after it and their number.

    Samples without a time are left out, the others sorted by time.

    Args:
        recording: with or without faults.
        longest_gap: longest time without a sample, > 0, s; times shorter than five usual steps are
            no gap.

    Raises:
        InvalidInput: if no sample has a time, or the gap is not positive.
    """
    longest = check.number(longest_gap, "longest_gap", above=0.0)
    whole = _as_recording(recording)
    whole = chosen(whole, np.flatnonzero(np.isfinite(whole.times)))
    whole = chosen(whole, np.argsort(whole.times, kind="stable"))
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
        for i, piece in enumerate((chosen(whole, rows) for rows in pieces), start=1)
    ]


def _as_recording(recording: Recording | Demonstration | Motion) -> Recording:
    if isinstance(recording, Motion):
        return recording_of(Demonstration(recording))
    if isinstance(recording, Demonstration):
        return recording_of(recording)
    if not isinstance(recording, Recording):
        got = type(recording).__name__
        raise InvalidInput(
            f"recording: expected a Recording, a Demonstration or a motion, got {got}"
        )
    return recording


def _rate(motion: Motion, asked: float | None, window: float | None) -> float | None:
    """Hz to sample at: what is asked for, or what smoothing needs."""
    if asked is None and window is not None and len(motion.times) > 1:
        return 1.0 / float(np.median(np.diff(motion.times)))
    return asked


def _resampled(
    demonstration: Demonstration, rate: float | None, window: float | None
) -> Demonstration:
    if rate is not None:
        demonstration = sample_evenly(demonstration, rate=rate)
    if window is not None:
        demonstration = smoothed_over(demonstration, window, "smoothing")
    return demonstration


def _without_faults(recording: Recording, factor: float | None) -> tuple[Recording, dict[str, Any]]:
    """The good samples in order, and the report's fields about the others."""
    valid = _valid(recording)
    kept = chosen(recording, np.flatnonzero(valid))
    if len(kept.times) == 0:
        raise InvalidInput("recording: expected some samples without missing numbers, got none")
    unordered = int(np.count_nonzero(kept.times < np.maximum.accumulate(kept.times)))
    kept = chosen(kept, np.argsort(kept.times, kind="stable"))
    fresh = np.diff(kept.times, prepend=-np.inf) > 0.0
    kept = chosen(kept, np.flatnonzero(fresh))
    kept, turned = _with_rotations(kept)
    leaps = _leaps(kept, factor)
    return chosen(kept, np.flatnonzero(~leaps)), {
        "invalid": tuple(np.flatnonzero(~valid).tolist()),
        "unordered": unordered,
        "repeated": int(np.count_nonzero(~fresh)),
        "spikes": tuple(kept.times[leaps].tolist()),
        **turned,
    }


def _valid(recording: Recording) -> NDArray[np.bool_]:
    numbers = np.column_stack([recording.times, *rows_of(recording).values()])
    valid = np.asarray((np.abs(numbers) < _MAX_NUMBER).all(axis=1))  # false for NaN
    if recording.orientations is not None:
        lengths = np.linalg.norm(np.where(valid[:, None], recording.orientations, 0.0), axis=1)
        valid &= (lengths > _MIN_LENGTH) & (lengths < 1.0 / _MIN_LENGTH)
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
                f"recording: no sample from {start:.6g} to {end:.6g} s; allow it with "
                f"longest_gap, now {longest:g} s, or cut it there, in Python with "
                "preprocess.cut_at_gaps"
            )


def _shortened(motion: MotionT, pauses: Sequence[Span], longest: float) -> MotionT:
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
    parts: dict[str, Any] = {name: values[rows] for name, values in rows_of(motion).items()}
    kept_events = events.clipped(events.moved(motion.events, old, new), times[fresh])
    return replace(motion, times=times[fresh], events=kept_events, **fields_of(motion, parts))
