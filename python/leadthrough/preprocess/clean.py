"""Makes demonstrations of recordings with faults, and summaries of recordings.

A sample is a spike by its distance from the median around it, relative to the usual distances and
steps there. Of the steps the larger ones count, so that a hand that stops abruptly is no fault.
Source of the spikes' test: after Hampel 1974, "The influence curve and its role in robust
estimation".
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check, rotations, sanity
from leadthrough.check import UNIT_LENGTH_TOLERANCE, Float64Array, InvalidInput, ShortRepr
from leadthrough.drawing import Drawn, Panel, spans_over_time
from leadthrough.io.recording import Recording, lost, recording_of
from leadthrough.motion import (
    Demonstration,
    Motion,
    MotionT,
    clipped_events,
    events_within,
    fields_of,
    moved_events,
    rows_of,
)
from leadthrough.preprocess.resample import sample_evenly
from leadthrough.preprocess.smooth import smoothed_over
from leadthrough.rest import rest_at_ends, rests, trim

Span = tuple[float, float]  # from and to, s

_LISTED = 5
_UNITS = {"joints": "rad (m)", "poses": "m", "points": "m"}
_WRAPPED: dict[str, Any] = {"width": 78, "subsequent_indent": "    ", "break_long_words": False}


@dataclass(frozen=True)
class CleaningReport(Drawn):
    """Faults of a recording and their corrections.

    Times are s on the recording's clock; samples are counted from 0 in the order of the file.

    Attributes:
        read: number of samples before cleaning.
        left: number of samples after it.
        invalid: samples left out: a number was missing, a quaternion no rotation, a target lost.
        unordered: number of samples later in the file than a sample of a later time.
        repeated: number of samples left out because another one had the same time.
        turns: number of leaps of joints by a whole turn, as encoders make, that were taken out.
        flipped: number of quaternions whose sign was changed.
        unnormalised: number of quaternions whose length was off 1 by more than rounding.
        spikes: times of samples left out because they jump away from their neighbours.
        gaps: start and end of the times without samples.
        pauses: start and end of the times without motion.
        removed: s of pauses cut out.
        still: s of standing still left out before and after the motion.
        rate: Hz of the new samples, or None.
        smoothing: s, window of the smoothing, or None.
    """

    read: int
    left: int
    invalid: tuple[int, ...] = ()
    unordered: int = 0
    repeated: int = 0
    turns: int = 0
    flipped: int = 0
    unnormalised: int = 0
    spikes: tuple[float, ...] = ()
    gaps: tuple[Span, ...] = ()
    pauses: tuple[Span, ...] = ()
    removed: float = 0.0
    still: Span = (0.0, 0.0)
    rate: float | None = None
    smoothing: float | None = None

    @property
    def faults(self) -> int:
        """Number of faults; a sample may have several."""
        counted = (self.unordered, self.repeated, self.flipped, self.unnormalised)
        return len(self.invalid) + len(self.spikes) + sum(counted)

    def as_dict(self) -> dict[str, Any]:  # Any: numbers and lists of them
        """The fields, as values that JSON can hold."""
        return asdict(self)

    def _repr_parts(self) -> list[str]:
        return str(self).splitlines()

    def _panels(self) -> list[Panel]:
        spikes = [(time, time) for time in self.spikes]
        rows = [
            (name, spans)
            for name, spans in (("pauses", self.pauses), ("gaps", self.gaps), ("spikes", spikes))
            if spans
        ]
        if not rows:
            raise InvalidInput("report: no pauses, gaps or spikes, so there is nothing to draw")
        return [spans_over_time(rows, title="pauses, gaps and spikes")]

    def __str__(self) -> str:
        missing = _some(self.invalid)
        lines = [f"{self.read} samples read, {self.left} left"]
        lines += [
            f"{count} {noun}{'s' if count > 1 else ''}{what}"
            for count, noun, what in (
                (len(self.invalid), "sample", f" with missing numbers, left out: {missing}"),
                (self.unordered, "sample", " out of order, sorted"),
                (self.repeated, "sample", " with a repeated time, left out"),
                (self.turns, "leap", " of a joint by a whole turn, made continuous"),
                (self.flipped, "quaternion", " of opposite sign, flipped"),
                (self.unnormalised, "quaternion", " not of length 1, normalised"),
                (len(self.spikes), "spike", f", left out: {_some(self.spikes)} s"),
                (len(self.gaps), "gap", f": {_spans(self.gaps)}"),
                (len(self.pauses), "pause", f": {_spans(self.pauses)}"),
            )
            if count
        ]
        if self.removed:
            lines.append(f"{self.removed:.3g} s of pauses cut out")
        if any(self.still):
            before, after = self.still
            lines.append(
                f"{before:.3g} s of standing still before the motion and {after:.3g} s after it "
                "left out"
            )
        if self.rate is not None:
            lines.append(f"resampled at {self.rate:.6g} Hz")
        if self.smoothing is not None:
            lines.append(f"smoothed with a window of {self.smoothing:.3g} s")
        return "\n".join(lines)


def _some(values: tuple[float, ...]) -> str:
    listed = ", ".join(f"{value:.6g}" for value in values[:_LISTED])
    return listed + (", ..." if len(values) > _LISTED else "")


def _spans(spans: tuple[Span, ...]) -> str:
    listed = ", ".join(f"{a:.13g} to {b:.13g} s" for a, b in np.round(spans[:_LISTED], 3))
    return listed + (", ..." if len(spans) > _LISTED else "")


@dataclass(frozen=True)
class RecordingSummary(ShortRepr):
    """The content of a recording, and whatever looks wrong."""

    name: str  # of the recording
    kind: str  # "joints", "poses" or "points"
    joints: tuple[str, ...]  # their names
    samples: int  # their number
    duration: float  # s
    rate: float  # Hz, by the median step; 0 for a single sample
    lower: tuple[float, ...]  # smallest value of each position
    upper: tuple[float, ...]  # largest value of each position
    events: tuple[str, ...]  # their names, in order
    report: CleaningReport | None
    remarks: tuple[str, ...]  # suspected faults

    @property
    def has_faults(self) -> bool:
        """Whether `clean` would leave samples out or put some right, or something looks wrong."""
        return bool(self.remarks) or self.report is None or self.report.faults > 0

    def as_dict(self) -> dict[str, Any]:  # Any: numbers, texts and lists of them
        """The fields, as values that JSON can hold."""
        return asdict(self)

    def __str__(self) -> str:
        lines = [f"{self.name}: {self.kind}, {self.samples} samples"]
        if self.report is not None:
            spans = zip(self.lower, self.upper, strict=True)
            lines[0] += f", {self.duration:.4g} s at {self.rate:.4g} Hz"
            ranges = ", ".join(f"{low:.3g} to {high:.3g}" for low, high in spans)
            lines.append(f"range in {_UNITS[self.kind]}: {ranges}")
            lines += str(self.report).splitlines()[1:]
        if self.joints:
            lines.append(f"joints {', '.join(self.joints)}")
        if self.events:
            lines.append(f"events {', '.join(self.events)}")
        lines += [f"! {remark}" for remark in self.remarks]
        return "\n  ".join(textwrap.fill(line, **_WRAPPED) for line in lines)


_GAP = 5.0  # median steps without a sample
_MIN_LENGTH = 0.5  # anything shorter, or longer than its inverse, was never a rotation
_SPIKE_WINDOW = 7  # samples of the median: up to three in a row may be wrong
_USUAL_WINDOW = 51  # samples whose distances and steps are the usual ones
# Changes between runs of rising times, per run, from which on these are recordings of their own.
_SHUFFLED = 10
_LARGER = 80  # percentile of the steps that counts; a few spikes stay above it
_TO_SIGMA = 1.4826  # standard deviation per median absolute deviation of a normal distribution
_TOGETHER = 1000  # samples whose windows are in memory at a time
_FLOOR = 1e-3  # fraction of a column's range; anything smaller is no spike
_ANY_GAP = 1e300  # s
_MAX_RATE = 1e5  # Hz; no arm is recorded so fast
_MIN_RATE = 1.0  # Hz; times in ms or ns that are read as s, and counters, are as slow
_MAX_REACH = 20.0  # m from an arm's base


def clean(
    recording: Recording | Demonstration[MotionT] | MotionT,
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
) -> tuple[Demonstration[MotionT], CleaningReport]:
    """A demonstration without a recording's faults, and a report of every change.

    Samples with a missing number or a quaternion that is no rotation are left out. The others are
    sorted by time, and of equal times the first is kept. Quaternions get length 1 and continuous
    signs, and joints that leap by whole turns are made continuous. No sample is made up: where some
    are left out, there are fewer.

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
        InvalidInput: if no sample is left, or a gap is too long.
    """
    factor = None if spike_factor is None else check.number(spike_factor, "spike_factor", above=0.0)
    window = None if smoothing is None else check.number(smoothing, "smoothing", above=0.0)
    raw = _as_recording(recording)
    kept, found = _without_faults(raw, factor)
    gaps = _gaps(kept.times)
    _check_gaps(gaps, check.number(longest_gap, "longest_gap", above=0.0))
    motion = replace(kept, events=clipped_events(kept.events, kept.times)).motion()
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
    hertz = rate
    result: Any = moving  # of the recording's own type of motion
    if rate is None and window is not None and len(moving.motion.times) > 1:
        hertz = 1.0 / float(np.median(np.diff(moving.motion.times)))
    if hertz is not None:
        result = sample_evenly(result, rate=hertz)
    if window is not None:
        result = smoothed_over(result, window, "smoothing")
    return result, CleaningReport(
        read=len(raw.times),
        left=len(result.motion.times),
        **found,
        gaps=tuple(gaps),
        pauses=tuple(pauses),
        removed=motion.duration - left.duration,
        still=rest_at_ends(left, moving.motion),
        rate=hertz,
        smoothing=smoothing,
    )


def cut_at_gaps(
    recording: Recording | Demonstration | Motion, *, longest_gap: float = 0.5
) -> list[Recording]:
    """The pieces of a recording between its gaps, in order, named after it and their number.

    Samples without a time are left out, the others sorted by time.

    Args:
        longest_gap: longest time without a sample, > 0, s; times shorter than five usual steps are
            no gap.
    """
    longest = check.number(longest_gap, "longest_gap", above=0.0)
    whole = _as_recording(recording)
    whole = _chosen(whole, np.flatnonzero(np.isfinite(whole.times)))
    whole = _chosen(whole, _in_time(whole.times))
    if len(whole.times) == 0:
        raise InvalidInput("recording: expected samples with times, got none")
    starts = [end for start, end in _gaps(whole.times) if end - start > longest]
    edges = [0, *np.searchsorted(whole.times, starts).tolist(), len(whole.times)]
    pieces = [np.arange(a, b) for a, b in pairwise(edges)]
    return [
        replace(
            piece,
            events=events_within(whole.events, float(piece.times[0]), float(piece.times[-1])),
            name=f"{whole.name} {i}".strip(),
        )
        for i, piece in enumerate((_chosen(whole, rows) for rows in pieces), start=1)
    ]


def summarize(recording: Recording) -> RecordingSummary:
    """The summary of a recording, whatever its faults."""
    check.instance(recording, "recording", Recording)
    known: dict[str, Any] = {
        "name": recording.name,
        "kind": recording.kind,
        "joints": recording.joint_names or (),
        "samples": len(recording.times),
        "events": tuple(event.name for event in recording.events),
    }
    try:
        demonstration, report = clean(recording, longest_gap=_ANY_GAP, rest=math.inf)
    except InvalidInput as error:
        nothing: dict[str, Any] = {"duration": 0.0, "rate": 0.0, "lower": (), "upper": ()}
        return RecordingSummary(**known, **nothing, report=None, remarks=(str(error),))
    motion = demonstration.motion
    steps = np.diff(motion.times)
    summary = RecordingSummary(
        **known,
        duration=motion.duration,
        rate=1.0 / float(np.median(steps)) if len(steps) else 0.0,
        lower=tuple(motion.positions.min(axis=0).tolist()),
        upper=tuple(motion.positions.max(axis=0).tolist()),
        report=report,
        remarks=(),
    )
    return replace(summary, remarks=_remarks(summary))


def _remarks(summary: RecordingSummary) -> tuple[str, ...]:
    remarks = []
    if summary.rate and not _MIN_RATE < summary.rate <= _MAX_RATE:
        remarks.append(f"{summary.rate:.3g} Hz: are the times in s?")
    farthest = max(map(abs, (*summary.lower, *summary.upper)))
    if len(summary.lower) == 3 and summary.kind != "joints" and farthest > _MAX_REACH:
        remarks.append(f"positions up to {farthest:.4g} m: are they in m? (x_mm names mm)")
    if summary.lower == summary.upper:
        remarks.append("nothing moves")
    return tuple(remarks)


def _as_recording(recording: Recording | Demonstration | Motion) -> Recording:
    if isinstance(recording, Motion):
        return recording_of(Demonstration(recording))
    if isinstance(recording, Demonstration):
        return recording_of(recording)
    check.instance(recording, "recording", Recording, "a Recording, a Demonstration or a motion")
    return recording


def _without_faults(recording: Recording, factor: float | None) -> tuple[Recording, dict[str, Any]]:
    """The good samples in order, and the report's fields about the others."""
    valid = _valid(recording)
    kept = _chosen(recording, np.flatnonzero(valid))
    if len(kept.times) == 0:
        raise InvalidInput("recording: expected some samples without missing numbers, got none")
    unordered = int(np.count_nonzero(kept.times < np.maximum.accumulate(kept.times)))
    kept = _chosen(kept, _in_time(kept.times))
    fresh = np.diff(kept.times, prepend=-np.inf) > 0.0
    kept = _chosen(kept, np.flatnonzero(fresh))
    kept, turns = _without_turns(kept)
    kept, rotation_counts = _with_rotations(kept)
    leaps = _leaps(kept, factor)
    return _chosen(kept, np.flatnonzero(~leaps)), {
        "invalid": tuple(np.flatnonzero(~valid).tolist()),
        "unordered": unordered,
        "repeated": int(np.count_nonzero(~fresh)),
        "turns": turns,
        "spikes": tuple(kept.times[leaps].tolist()),
        **rotation_counts,
    }


def _without_turns(recording: Recording) -> tuple[Recording, int]:
    if recording.joint_names is None:
        return recording, 0
    positions = sanity.without_turns(recording.positions)
    changes = np.diff(positions - recording.positions, axis=0)
    return replace(recording, positions=positions), int(np.count_nonzero(np.abs(changes) > np.pi))


def _in_time(times: Float64Array) -> NDArray[np.int64]:
    """The samples in the order of their times. Refuses runs that would be shuffled together."""
    order = np.argsort(times, kind="stable")
    back = np.diff(times) < 0.0
    run = np.cumsum(np.concatenate([[False], back]))
    if np.count_nonzero(np.diff(run[order])) > _SHUFFLED * np.count_nonzero(back):
        i = int(np.argmax(back))
        raise InvalidInput(
            f"recording: its times start again, with {times[i + 1]:.6g} s behind {times[i]:.6g} s; "
            "divide it there into two recordings"
        )
    return order


def _valid(recording: Recording) -> NDArray[np.bool_]:
    numbers = np.column_stack([recording.times, *rows_of(recording).values()])
    valid = np.asarray((np.abs(numbers) < check.MAX_NUMBER).all(axis=1))  # false for NaN
    valid[valid] = ~lost(recording.positions[valid])
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
    leaps = _spikes(recording.positions, factor)
    if recording.orientations is not None:
        leaps |= _spikes(recording.orientations, factor)
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
                f"recording: no sample from {round(start, 3):.13g} to {round(end, 3):.13g} s; "
                f"allow it with longest_gap, now {longest:g} s, or cut it there, in Python with "
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
    kept_events = clipped_events(moved_events(motion.events, old, new), times[fresh])
    return replace(motion, times=times[fresh], events=kept_events, **fields_of(motion, parts))


def _spikes(values: Float64Array, factor: float) -> NDArray[np.bool_]:
    """Flags (n,) of the rows (n, d) that jump away from their neighbours."""
    if len(values) <= _SPIKE_WINDOW:
        return np.zeros(len(values), dtype=bool)
    centre = _ranked(values, _SPIKE_WINDOW, 50)
    off = np.abs(values - centre)
    steps = np.abs(np.diff(values, axis=0, append=values[-1:]))
    noise = _TO_SIGMA * _ranked(off, _USUAL_WINDOW, 50)
    pace = _ranked(steps, _USUAL_WINDOW, _LARGER)
    least = _FLOOR * np.ptp(centre, axis=0) + np.spacing(np.abs(centre).max(axis=0)) * _USUAL_WINDOW
    return np.asarray((off > factor * (noise + pace) + least).any(axis=1))


def _ranked(values: Float64Array, size: int, percent: int) -> Float64Array:
    """A percentile (n, d) of the samples around each, mirrored at the ends."""
    rank, beside = size * percent // 100, size // 2
    mirrored = np.pad(values, ((beside, beside), (0, 0)), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(mirrored, size, axis=0)
    result = np.empty_like(values)
    for first in range(0, len(values), _TOGETHER):
        rows = slice(first, first + _TOGETHER)
        result[rows] = np.partition(windows[rows], rank)[..., rank]
    return result


def _chosen(recording: Recording, samples: NDArray[np.intp]) -> Recording:
    """The recording of samples by their indices, with all events."""
    rows = {name: rows[samples] for name, rows in rows_of(recording).items()}
    return replace(recording, times=recording.times[samples], **fields_of(recording, rows))
