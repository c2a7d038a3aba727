"""What cleaning found in a recording, and what it changed."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

Span = tuple[float, float]  # from and to, s

_LISTED = 5


@dataclass(frozen=True)
class CleaningReport:
    """Times are s on the recording's clock; samples count from 0 in the order of the file.

    read, left: samples before and after. invalid: samples left out because a number was missing,
    or no rotation. unordered: samples that came before their time. repeated: samples left out
    because their time was there already. flipped: quaternions whose sign was turned.
    unnormalised: quaternions off length 1 by more than a recorder's rounding. spikes: times of
    samples left out because they leap away from their neighbours. gaps, pauses: where nothing was
    recorded, and where nothing moved. removed: s of pauses taken out. rate: Hz sampled at anew.
    smoothing: s, the window smoothed over.
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
    rate: float | None = None
    smoothing: float | None = None

    @property
    def faults(self) -> int:
        """How many samples were wrong in some way."""
        counted = (self.unordered, self.repeated, self.flipped, self.unnormalised)
        return len(self.invalid) + len(self.spikes) + sum(counted)

    def as_dict(self) -> dict[str, Any]:
        """The fields, as values that JSON knows."""
        return asdict(self)

    def __str__(self) -> str:
        lines = [f"{self.read} samples read, {self.left} left"]
        lines += [
            f"{count} {what}"
            for count, what in (
                (len(self.invalid), f"without a number, left out: {_some(self.invalid)}"),
                (self.unordered, "out of order, sorted"),
                (self.repeated, "at a time that was there already, left out"),
                (self.flipped, "quaternions of the other sign, turned"),
                (self.unnormalised, "quaternions of another length, normalised"),
                (len(self.spikes), f"spikes, left out: {_some(self.spikes)} s"),
                (len(self.gaps), f"gaps: {_spans(self.gaps)}"),
                (len(self.pauses), f"pauses: {_spans(self.pauses)}"),
            )
            if count
        ]
        if self.removed:
            lines.append(f"{self.removed:.3g} s of pauses taken out")
        if self.rate is not None:
            lines.append(f"sampled anew at {self.rate:.6g} Hz")
        if self.smoothing is not None:
            lines.append(f"smoothed over {self.smoothing:.3g} s")
        return "\n".join(lines)


def _some(values: tuple[float, ...]) -> str:
    listed = ", ".join(f"{value:.6g}" for value in values[:_LISTED])
    return listed + (", ..." if len(values) > _LISTED else "")


def _spans(spans: tuple[Span, ...]) -> str:
    listed = ", ".join(f"{start:.4g} to {end:.4g} s" for start, end in spans[:_LISTED])
    return listed + (", ..." if len(spans) > _LISTED else "")
