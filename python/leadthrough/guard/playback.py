"""A motion commanded one period at a time, which can be paused, resumed and slowed down.

The motion q(s) is run by a phase s whose speed a jerk filter leads to the speed that is asked for,
so that the arm stays on its path. With the largest rates v, a, j of the motion and the limits A, J,

    |s''| <= min((A - a) / v, (J - j) / (6 a)),  |s'''| <= (J - j) / (2 v)

keep the acceleration q'' s'^2 + q' s'' and the jerk q''' s'^3 + 3 q'' s' s'' + q' s''' inside them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import JointLimits
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.trajectories.filters import FilterState, JerkFilter

_MIN_ROOM = 0.01  # fraction of a limit that a motion has to leave
_MIN_RATE, _MAX_RATE = 1.0, 1e4  # Hz
_EASIEST = 100.0  # 1/s^2: a motion that hardly moves may stop within some periods


@dataclass(frozen=True, eq=False)
class Push(ShortRepr):
    """A person's hand on a compliant arm, where it was the farthest off its path.

    With the tip's positions, or the joints of a skill of joints, it is a correction of the skill:
    `skill.corrected(tip(push.commanded), tip(push.measured))`.

    Attributes:
        time: of the motion, s.
        commanded: joint positions (joints,), rad (m).
        measured: joint positions (joints,), rad (m).
    """

    time: float
    commanded: Float64Array
    measured: Float64Array

    @property
    def size(self) -> float:
        """The largest difference of a joint, rad (m)."""
        return float(np.abs(self.measured - self.commanded).max())


class Playback(ShortRepr):
    """A motion commanded one period at a time, with adjustable speed.

        play = lt.guard.Playback(motion, arm.limits, rate=1000.0)
        while not play.done:
            guard.admit(play.next()[None])
            send(guard.next())

    It stays on its path, and inside the limits of acceleration and jerk while its speed changes:
    the more room a motion leaves below them, the sooner it pauses. The motion has to begin and end
    at rest; `lt.connect` makes it so.

    Attributes:
        push: the place where the measured joints were the farthest from the commanded ones so
            far; None without any.

    Args:
        motion: of an arm's joints, at any rate.
        limits: of the same joints; acceleration and jerk have to be known.
        rate: commands per second, 1 to 1e4.

    Raises:
        InvalidInput: if the motion has fewer than two samples or other joints, a limit is not
            known, or the motion leaves less than a hundredth of an acceleration or jerk limit.
    """

    def __init__(self, motion: JointTrajectory, limits: JointLimits, *, rate: float) -> None:
        from scipy.interpolate import CubicSpline

        self._period = 1.0 / check.number(rate, "rate", at_least=_MIN_RATE, at_most=_MAX_RATE)
        motion = in_order(motion, limits.joint_names, "motion")
        if len(motion) < 2:
            raise InvalidInput("motion: expected at least two samples, got one")
        self._times = motion.times
        self._curve = CubicSpline(motion.times, motion.positions, bc_type="clamped")
        bend, jerk = _phase_limits(motion, limits)
        self._filter = JerkFilter(bend, jerk, jerk / self._period)
        self._now: FilterState | None = None
        self._phase = float(motion.times[0])
        self._asked = 1.0
        self._paused = False
        self.push: Push | None = None

    @property
    def speed(self) -> float:
        """Requested speed, 0 to 1, as a fraction of the motion's; can be set."""
        return self._asked

    @speed.setter
    def speed(self, value: float) -> None:
        self._asked = check.number(value, "speed", at_least=0.0, at_most=1.0)

    @property
    def speed_now(self) -> float:
        """Current speed, which follows the requested one; 0 before the first period."""
        return 0.0 if self._now is None else float(self._now.position[0])

    @property
    def paused(self) -> bool:
        """Whether it is paused, or slowing down to be."""
        return self._paused

    @property
    def done(self) -> bool:
        """Whether the end has been commanded."""
        return bool(self._phase >= self._times[-1])

    @property
    def time(self) -> float:
        """Present time of the motion, s on its own clock."""
        return self._phase

    def pause(self) -> None:
        """Slows down to rest on the path."""
        self._paused = True

    def resume(self) -> None:
        """Goes on."""
        self._paused = False

    def next(self, measured: ArrayLike | None = None) -> Float64Array:
        """Advances by one period; the joint positions to command (joints,).

        Args:
            measured: the present joint positions (joints,), rad (m); see `push`.
        """
        if measured is not None:
            self._measure(check.array(measured, "measured", shape=self._curve.c.shape[2:]))
        target = np.array([0.0 if self._paused else self._asked])
        # The motion begins at rest, where any speed will do.
        before = FilterState.at_rest(target) if self._now is None else self._now
        self._now = self._filter.step(before, target, self._period)
        gone = max(self.speed_now, 0.0) * self._period
        self._phase = min(self._phase + gone, float(self._times[-1]))
        return np.asarray(self._curve(self._phase))

    def _measure(self, q: Float64Array) -> None:
        found = Push(self._phase, np.asarray(self._curve(self._phase)), q)
        if self.push is None or found.size > self.push.size:
            self.push = found


def _phase_limits(motion: JointTrajectory, limits: JointLimits) -> tuple[float, float]:
    """The largest acceleration, 1/s, and jerk, 1/s^2, of the phase."""
    if limits.acceleration is None or limits.jerk is None:
        raise InvalidInput("limits: expected acceleration and jerk limits, got none")
    steps = np.diff(motion.times)[:, None]
    speeds = np.diff(motion.positions, axis=0) / steps
    bends = np.diff(speeds, axis=0) / (0.5 * (steps[1:] + steps[:-1]))
    jerks = np.diff(bends, axis=0) / steps[1:-1]
    v, a, j = (np.abs(rows).max(axis=0, initial=0.0) for rows in (speeds, bends, jerks))
    room, jerk_room = limits.acceleration - a, limits.jerk - j
    for left, limit, name in (
        (room, limits.acceleration, "acceleration"),
        (jerk_room, limits.jerk, "jerk"),
    ):
        if (left < _MIN_ROOM * limit).any():
            joint = limits.joint_names[int(np.argmin(left / limit))]
            raise InvalidInput(
                f"motion: expected room below the {name} limit of {joint}, to change the speed on "
                "the path; time the motion with lower limits, such as half of them"
            )
    tiny = np.finfo(np.float64).tiny
    bend = min((room / (v + tiny)).min(), (jerk_room / (6.0 * a + tiny)).min(), _EASIEST)
    return float(bend), float(min((0.5 * jerk_room / (v + tiny)).min(), _EASIEST**2))
