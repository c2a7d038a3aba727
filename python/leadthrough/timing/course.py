"""The time law along a smooth path, for given bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadthrough import _core
from leadthrough.arm.limits import JointLimits
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing.bounds import PathBounds
from leadthrough.timing.rates import Rates
from leadthrough.timing.samples import Samples, differentiated
from leadthrough.timing.sections import Section

# The most samples of a motion.
MAX_SAMPLES = 1e7
_COARSEST_PERIOD = 1e-3  # s; at lower rates several samples are computed for each one returned
_SAME_PARAMETER = 1e-9  # relative to the section
_STATUSES = (
    "ok",
    "no_motion",
    "start_too_fast",
    "end_too_fast",
    "too_long",
    "not_settled",
    "creeps",
)


def computed_for_each(rate: float) -> int:
    """How many samples are computed for each one returned at a rate."""
    return max(1, math.ceil(1.0 / (rate * _COARSEST_PERIOD) - 1e-9))


class Creeping(Exception):
    """The motion takes far longer than its profile, for its pinches."""

    def __init__(self, pinches: Float64Array) -> None:
        super().__init__()
        self.pinches = pinches


@dataclass(frozen=True, eq=False)
class Law:
    """A time law."""

    times: Float64Array  # s, (n,)
    length: Float64Array  # the path's length at them, (n,)
    pinches: Float64Array


@dataclass(frozen=True, eq=False)
class Course:
    """What the time law of a section is computed from, apart from the bounds on it."""

    path: _core.TimedPath  # the path and its grid
    section: Section  # what it is the path of
    rates: Rates  # of the joints along it
    limits: JointLimits  # of the joints
    speeds: tuple[float, float]  # of the path's length, at its ends
    rate: float  # samples per second
    most_delay: float

    @property
    def parts(self) -> int:
        """Samples computed for each one returned."""
        return computed_for_each(self.rate)

    @property
    def period(self) -> float:
        """Time between computed samples, s."""
        return 1.0 / (self.rate * self.parts)

    def law(self, extra: PathBounds) -> Law:
        """The time law inside the bounds."""
        status, point, length, duration, _, _, points = self.path.law(
            self.rates.velocity,
            self.rates.acceleration,
            self.rates.jerk,
            extra.fastest,
            extra.gain,
            extra.bend,
            extra.lower,
            extra.upper,
            self.period,
            *self.speeds,
            MAX_SAMPLES,
            self.most_delay,
        )
        pinches = self.path.parameter[points]
        if status and len(pinches):
            raise Creeping(pinches)
        if status:
            raise _failure(_STATUSES[status], self.path.first[point], self.limits)
        if self.speeds[1] == 0.0:
            missing = -(len(length) - 1) % self.parts
            length = np.concatenate([length, np.full(missing, length[-1])])
            duration = self.period * (len(length) - 1)
        times = np.arange(len(length), dtype=np.float64) * self.period
        times[-1] = duration
        return Law(times, length, pinches)

    def motion(self, law: Law) -> Samples:
        """The motion of a law, sampled at the rate asked for."""
        q = self.path.positions_at(law.length)
        places = _places(law.length, self.path, self.section)
        every = differentiated(law.times, places, q, self.path, speeds=self.speeds)
        return every.thinned(self.parts)


def _places(length: Float64Array, path: _core.TimedPath, section: Section) -> Float64Array:
    """Places (n,) of a motion, counted in way-points, samples or knots of the whole path."""
    parameters = np.interp(length, path.length, path.parameter)
    places = np.interp(parameters, section.parameters, section.rows)
    # Exact at the ends of the whole, where rounding would miss them.
    near = _SAME_PARAMETER * float(section.parameters[-1] - section.parameters[0])
    for end in (0, -1):
        if abs(path.parameter[end] - section.parameters[end]) <= near:
            places[end] = section.rows[end]
    return places


def _failure(status: str, direction: Float64Array, limits: JointLimits) -> Exception:
    with np.errstate(divide="ignore", invalid="ignore"):
        need = np.nan_to_num(np.abs(direction) / limits.velocity)
    name = limits.joint_names[int(need.argmax())]
    if status == "too_long":
        return InvalidInput(f"rate: expected at most {MAX_SAMPLES:.0e} samples; lower the rate")
    reasons = {
        "no_motion": "no motion along the path keeps the limits",
        "start_too_fast": "start_velocity is faster than the limits allow",
        "end_too_fast": "end_velocity is faster than the limits allow",
        "not_settled": "no motion with these velocities at the ends keeps the limits",
    }
    return LimitsInfeasible(f"{reasons[status]}; the joint nearest its limit is {name}", joint=name)
