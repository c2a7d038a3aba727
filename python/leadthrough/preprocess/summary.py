"""The content of a recording, and what looks wrong with it."""

from __future__ import annotations

import math
import textwrap
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from leadthrough.errors import InvalidInput
from leadthrough.io.recording import Recording
from leadthrough.preprocess.clean import clean
from leadthrough.preprocess.report import CleaningReport
from leadthrough.repr import ShortRepr

_ANY_GAP = 1e300  # s
_FASTEST = 1e5  # Hz; no arm is recorded so fast
_SLOWEST = 0.5  # Hz; times in ms or ns that are read as s look slower
_MAX_REACH = 20.0  # m from an arm's base
_UNITS = {"joints": "rad (m)", "poses": "m", "points": "m"}
_WRAPPED: dict[str, Any] = {"width": 78, "subsequent_indent": "    ", "break_long_words": False}


@dataclass(frozen=True)
class RecordingSummary(ShortRepr):
    """What one recording holds."""

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
    remarks: tuple[str, ...]  # what looks wrong

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


def summarize(recording: Recording) -> RecordingSummary:
    """The summary of a recording, whatever its faults."""
    if not isinstance(recording, Recording):
        raise InvalidInput(f"recording: expected a Recording, got {type(recording).__name__}")
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
    if summary.rate and not _SLOWEST <= summary.rate <= _FASTEST:
        remarks.append(f"{summary.rate:.3g} Hz: are the times in s?")
    farthest = max(map(abs, (*summary.lower, *summary.upper)))
    if summary.kind == "poses" and farthest > _MAX_REACH:
        remarks.append(f"positions up to {farthest:.4g} m: are they in m?")
    if summary.lower == summary.upper:
        remarks.append("nothing moves")
    return tuple(remarks)
