"""Movement primitives of poses: position and orientation on one phase.

How the orientation is represented stands in `turning`; what moves it, in `springs`.
Source: Lauretti et al. 2023, "Robot learning by demonstration with dynamic parameterization of the
orientation", Robotics 12:166, for the representations and the planner that ours is compared with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.errors import InvalidInput
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp import turning
from leadthrough.models.dmp.kernels import MOST_WEIGHTS, enough_weights
from leadthrough.models.dmp.mean_motion import mean_motion
from leadthrough.models.dmp.pose_skill import PoseDMPSkill
from leadthrough.models.dmp.primitive import take_settings
from leadthrough.models.dmp.regression import REGRESSIONS, fit
from leadthrough.models.dmp.spin import replayed_angle
from leadthrough.models.dmp.springs import FORMS, Springs
from leadthrough.models.dmp.turning import REPRESENTATIONS, Turning
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import Motion, PoseTrajectory

_POSITION, _ORIENTATION = slice(3), slice(3, 6)  # channels


@dataclass(frozen=True)
class PoseDMP(Unfitted):
    """Dynamic movement primitives of poses; `lauretti` makes the planner of Lauretti et al. 2023.

    Attributes:
        weights: as in `DMP`.
        orientation: "anchored", which holds for any rotation; "lifted" (Lauretti et al. 2023), up
            to about 220 degrees; "log" and "euler" (ZYZ), which break where they jump.
        regression: as in `DMP`.
        form: as in `DMP`, of position and orientation. "ijspeert" scales the forces of the
            orientation by its coordinates at the start, seen from the goal; "anchored" has none.

    Raises:
        InvalidInput: if a setting is outside its range, and for the form "ijspeert" with
            "anchored".
    """

    weights: int | None = 50
    orientation: str = "anchored"
    regression: str = "replay"
    form: str = "blended"

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=2, at_most=MOST_WEIGHTS)
        check.choice(self.orientation, "orientation", REPRESENTATIONS)
        check.choice(self.regression, "regression", REGRESSIONS)
        check.choice(self.form, "form", FORMS)
        if self.form == "ijspeert" and self.orientation == "anchored":
            raise InvalidInput(
                'orientation: "anchored" begins and ends at 0, which scales no force of the form '
                '"ijspeert"; use "lifted", or another form'
            )

    @staticmethod
    def lauretti(weights: int | None = 50) -> PoseDMP:
        """The planner of Lauretti et al. 2023 by its own equations, to compare with.

        Springs drive position and orientation, with forces scaled by goal - start (eqs. 1, 2 and A1
        to A7), the dynamic parameterisation of the logarithm (eqs. 7 to 9) and locally weighted
        regression. The logarithm is that of the rotation from the goal, in the goal's axes. Slips
        in the paper are corrected: time is scaled alike in all terms, the logarithm in eq. 6 is
        constant, and omega, the derivative of the rotation vector, is integrated before exp.

        Its weaknesses are the paper's: a motion of which a channel ends where it began is refused;
        a new goal on the other side of the start in a channel mirrors that channel; where goal -
        start is small, a small change of it throws the motion; the tool may spin towards a new
        goal.

        Args:
            weights: as in `DMP`.

        Raises:
            InvalidInput: if weights is outside its range.
        """
        return PoseDMP(weights, orientation="lifted", regression="lwr", form="ijspeert")

    def fit(self, demonstrations: Demonstrations[Motion]) -> PoseDMPSkill:
        """A skill from demonstrations of poses; several are averaged over normalised time first.

        Args:
            demonstrations: all of poses.

        Raises:
            InvalidInput: for other motions.
            FitError: for one that does not move, for several whose orientations lie too far apart
                for a mean, where "lifted" would spin, and with the form "ijspeert" for one of which
                a channel ends where it began.
        """
        mean = mean_motion(demonstrations, (PoseTrajectory,))
        assert mean.orientations is not None
        turned, coordinates = turning.learn(mean.phases, mean.orientations, self.orientation)
        count = self.weights or enough_weights(mean.duration)
        learned = fit(
            mean.phases,
            np.hstack([mean.positions, coordinates]),
            weights=count,
            form=self.form,
            regression=self.regression,
            groups=(_POSITION, _ORIENTATION),
        )
        model = replace(self, weights=count)
        known = (mean.duration, mean.size, mean.events, turned)
        skill = PoseDMPSkill(model, learned, *known, posture=mean.posture)
        if not skill.refuses_spins:
            return skill
        angle = replayed_angle(learned, turned, skill.begin(), mean.phases, mean.orientations)
        return replace(skill, turning=replace(turned, angle=angle))


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> PoseDMPSkill:
    """The skill that `PoseDMPSkill.to_archive` took apart."""
    duration, size, happening, posture = take_settings(settings, arrays)
    model = PoseDMP(**settings)
    learned = Springs.from_arrays(model.form, settings["weights"], arrays)
    turned = Turning.from_arrays(model.orientation, arrays)
    return PoseDMPSkill(model, learned, duration, size, happening, turned, posture=posture)
