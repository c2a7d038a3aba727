"""Movement primitives of points, joints and poses.

The equations of the forms stand in `springs`, those of the fits in `regression`, and the
representations of orientations in `turning`. Position and orientation of a pose share one phase.
Sources: Ijspeert et al. 2013, "Dynamical movement primitives", Neural Computation 25; Hoffmann et
al. 2009, "Biologically-inspired dynamical systems for movement generation".
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import check, events
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.archive import Arrays
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp.kernels import MOST_WEIGHTS, enough_weights
from leadthrough.models.dmp.mean_motion import MeanMotion, mean_motion
from leadthrough.models.dmp.regression import REGRESSIONS, fit
from leadthrough.models.dmp.skill import DMPSkill
from leadthrough.models.dmp.spin import refuses_spins, replayed_angle
from leadthrough.models.dmp.springs import FORMS, Springs
from leadthrough.models.dmp.turning import REPRESENTATIONS, Turning, learn
from leadthrough.models.posture import Posture
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import MotionT


@dataclass(frozen=True)
class DMP(Unfitted):
    """Dynamic movement primitives of points in any number of dimensions, of joints, or of poses.

    Attributes:
        weights: number of kernels per channel, 2 to 1000; None: 4 per second and at least 50, as
            long motions with many details need.
        form: "blended", which meets start, goal and velocities exactly; "hoffmann" (Hoffmann et al.
            2009, Pastor et al. 2009), whose force is not scaled by the goal either; "ijspeert"
            (Ijspeert et al. 2002, 2013), whose force is. At the end of a motion the last two are
            only near a new goal: "hoffmann" lacks 2.5 % of what start and goal were moved by
            (0.03 % after half as long again, in `step`), "ijspeert" its error in replay, scaled.
        regression: "replay" minimises the error of the replayed motion; "ridge" and "lwr" fit the
            force that finite differences ask for, all kernels together or each by itself.
        orientation: coordinates of the orientation of poses: "anchored", which holds for any
            rotation; "lifted" (Lauretti et al. 2023), up to about 220 degrees; "log" and "euler"
            (ZYZ), which break where they jump. The form "ijspeert" scales the orientation's forces
            by these coordinates at the start, seen from the goal; "anchored" has none.

    Raises:
        InvalidInput: if a setting is outside its range.
    """

    weights: int | None = 50
    form: str = "blended"
    regression: str = "replay"
    orientation: str = "anchored"

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=2, at_most=MOST_WEIGHTS)
        check.choice(self.form, "form", FORMS)
        check.choice(self.regression, "regression", REGRESSIONS)
        check.choice(self.orientation, "orientation", REPRESENTATIONS)

    @staticmethod
    def lauretti(weights: int | None = 50) -> DMP:
        """The planner of Lauretti et al. 2023 for poses by its own equations, to compare with.

        Springs drive position and orientation, with forces scaled by goal - start (eqs. 1, 2 and A1
        to A7), the dynamic parameterisation of the logarithm (eqs. 7 to 9) and locally weighted
        regression. The logarithm is that of the rotation from the goal, in the goal's axes. Slips
        in the paper are corrected: time is scaled alike in all terms, the logarithm in eq. 6 is
        constant, and omega, the derivative of the rotation vector, is integrated before exp.

        Its weaknesses are the paper's: a motion of which a channel ends where it began is refused;
        a new goal on the other side of the start in a channel mirrors that channel; where goal -
        start is small, a small change of it distorts the motion strongly; the tool may spin towards
        a new goal.

        Args:
            weights: as the attribute.

        Raises:
            InvalidInput: if weights is outside its range.
        """
        return DMP(weights, form="ijspeert", regression="lwr", orientation="lifted")

    def fit(self, demonstrations: Demonstrations[MotionT]) -> DMPSkill[MotionT]:
        """A skill from demonstrations; several are averaged over normalised time first.

        Args:
            demonstrations: all of points, all of joints or all of poses.

        Raises:
            InvalidInput: for other motions, and for poses with the form "ijspeert" and the
                orientation "anchored".
            FitError: for one that does not move, and with the form "ijspeert" for one of which a
                channel ends where it began; for several whose orientations lie too far apart for a
                mean, and where "lifted" would spin.
        """
        mean = mean_motion(demonstrations)
        turned, values, groups = self._channels(mean)
        count = self.weights or enough_weights(mean.duration)
        learned = fit(
            mean.phases,
            values,
            weights=count,
            form=self.form,
            regression=self.regression,
            groups=groups,
        )
        skill: DMPSkill[MotionT] = DMPSkill(
            model=replace(self, weights=count),
            springs=learned,
            duration=mean.duration,
            size=mean.size,
            events=mean.events,
            joint_names=mean.joint_names,
            turning=turned,
            posture=mean.posture,
        )
        if turned is None or mean.orientations is None or not refuses_spins(learned, turned):
            return skill
        angle = replayed_angle(learned, turned, skill.begin(), mean.phases, mean.orientations)
        return replace(skill, turning=replace(turned, angle=angle))

    def _channels(self, mean: MeanMotion) -> tuple[Turning | None, Float64Array, tuple[slice, ...]]:
        """Coordinates of the orientation, values (n, channels), and channels of the same unit."""
        if mean.orientations is None:
            return None, mean.positions, (slice(None),)
        if self.form == "ijspeert" and self.orientation == "anchored":
            raise InvalidInput(
                'orientation: "anchored" begins and ends at 0, which scales no force of the form '
                '"ijspeert"; use "lifted", or another form'
            )
        turned, coordinates = learn(mean.phases, mean.orientations, self.orientation)
        return turned, np.hstack([mean.positions, coordinates]), (slice(3), slice(3, 6))


def from_archive(settings: dict[str, Any], arrays: Arrays) -> DMPSkill:
    """The skill that `DMPSkill.to_archive` took apart."""
    duration = check.number(settings.pop("duration"), "duration", above=0.0)
    size = check.number(settings.pop("size"), "size", at_least=0.0)
    happening = events.from_plain(settings.pop("events", ()))
    names = settings.pop("joint_names", None)
    posture = Posture.from_archive(settings, arrays)
    model = DMP(**settings)
    poses = "controls" in arrays
    return DMPSkill(
        model=model,
        springs=Springs.from_arrays(model.form, settings["weights"], arrays),
        duration=duration,
        size=size,
        events=happening,
        joint_names=None if names is None else tuple(names),
        turning=Turning.from_arrays(model.orientation, arrays) if poses else None,
        posture=posture,
    )
