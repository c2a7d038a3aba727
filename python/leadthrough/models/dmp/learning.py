"""Learned parts of primitives from demonstrations, discrete and rhythmic."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import InvalidInput
from leadthrough.models.dmp.mean_motion import MeanMotion, mean_cycle, mean_motion
from leadthrough.models.dmp.orientation import (
    REPRESENTATIONS,
    OrientationCoordinates,
    learn,
    learn_closed,
)
from leadthrough.models.dmp.poses import PoseChannels
from leadthrough.models.dmp.primitive import Parts
from leadthrough.models.dmp.regression import REGRESSIONS, fit, fit_rhythm, fit_with_enough
from leadthrough.models.dmp.transformation import (
    FORMS,
    MAX_WEIGHTS,
    TransformationSystem,
)
from leadthrough.models.protocol import Demonstrations
from leadthrough.motion import Motion

_POSITION, _ORIENTATION = slice(3), slice(3, 6)  # channels of poses


def check_weights(weights: int, *, at_least: int) -> None:
    """Refuses a number of kernels out of range."""
    check.integer(weights, "weights", at_least=at_least, at_most=MAX_WEIGHTS)


def check_choices(form: str, regression: str, orientation: str) -> None:
    """Refuses a form, a regression or an orientation that there is not."""
    check.choice(form, "form", FORMS)
    check.choice(regression, "regression", REGRESSIONS)
    check.choice(orientation, "orientation", REPRESENTATIONS)


def learn_motion(
    demonstrations: Demonstrations[Motion],
    weights: int | None,
    *,
    form: str,
    regression: str,
    orientation: str,
) -> tuple[MeanMotion, Parts]:
    """The mean of demonstrations, and the parts of a discrete primitive that follows it."""
    mean = mean_motion(demonstrations)
    coordinates, values = None, mean.positions
    groups: tuple[slice, ...] = (slice(None),)
    if mean.orientations is not None:
        if form == "ijspeert" and orientation == "anchored":
            raise InvalidInput(
                'orientation: "anchored" begins and ends at 0, which scales no force of the form '
                '"ijspeert"; use "lifted", or another form'
            )
        coordinates, rotated = learn(mean.phases, mean.orientations, orientation)
        values, groups = np.hstack([values, rotated]), (_POSITION, _ORIENTATION)
    settings: Any = {"form": form, "regression": regression, "groups": groups}
    if weights is None:
        system = fit_with_enough(mean.phases, values, **settings)
    else:
        system = fit(mean.phases, values, weights=weights, **settings)
    if coordinates is not None and mean.orientations is not None:
        channels = PoseChannels(system, mean.size, coordinates)
        if channels.refuses_spins:
            angle = channels.replayed_angle(mean.phases, mean.orientations)
            coordinates = replace(coordinates, angle=angle)
    return mean, _parts(mean, system, coordinates)


def learn_rhythm(
    demonstrations: Demonstrations[Motion], weights: int, period: float | None
) -> tuple[MeanMotion, Parts]:
    """The mean period of demonstrations, and the parts of a rhythmic primitive that follows it."""
    mean = mean_cycle(demonstrations, period)
    coordinates, values = None, mean.positions
    if mean.orientations is not None:
        coordinates, rotated = learn_closed(mean.phases, mean.orientations)
        values = np.hstack([values, rotated])
    system = fit_rhythm(mean.phases, values, weights=weights)
    if coordinates is not None:
        begun = system.ends.start[None, _ORIENTATION].copy()
        first = coordinates.orientations(np.zeros(1), begun)[0]
        coordinates = replace(coordinates, start=first, goal=first)
    return mean, _parts(mean, system, coordinates)


def _parts(
    mean: MeanMotion, system: TransformationSystem, coordinates: OrientationCoordinates | None
) -> Parts:
    return Parts(
        system=system,
        events=mean.events,
        joint_names=mean.joint_names,
        orientation=coordinates,
        posture=mean.posture,
    )
