"""Reports on recordings: the faults that `clean` removed, and summaries."""

from __future__ import annotations

import textwrap
from dataclasses import asdict, dataclass
from typing import Any

from leadthrough.check import InvalidInput, ShortRepr
from leadthrough.drawing import Drawn, Panel, spans_over_time

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
        invalid: samples left out because a number was missing or a quaternion was no rotation.
        unordered: number of samples later in the file than a sample of a later time.
        repeated: number of samples left out because another one had the same time.
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
    listed = ", ".join(f"{start:.4g} to {end:.4g} s" for start, end in spans[:_LISTED])
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
