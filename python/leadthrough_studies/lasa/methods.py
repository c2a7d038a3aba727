"""The methods that the handwriting study compares; another joins with one line in `METHODS`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models import GMR, FastMarching, ProMP, model_entry
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.preprocess.resample import arc_length

Shown = Sequence[Demonstration[Trajectory]]
Method = Callable[[Shown, Float64Array], Trajectory]

# The protocol whose paths are drawn.
HEADLINE = "LOO"
PIXELS_PER_MM = 8.3
PAPER_AREA_OF_INFLUENCE = 25.0 / PIXELS_PER_MM  # mm
PAPER_SATURATION = 0.1


class _Model(Protocol):
    def fit(self, demonstrations: Shown) -> Any: ...


def paper_setting(saturation: float = PAPER_SATURATION, **options: Any) -> FastMarching:
    """Algorithm 1 of Prados et al. 2023 at one cell per pixel, area of influence 25 pixels."""
    return FastMarching(
        area_of_influence=PAPER_AREA_OF_INFLUENCE,
        saturation=saturation,
        resolution=1.0 / PIXELS_PER_MM,
        method="map",
        **options,
    )


def generated_by(model: _Model) -> Method:
    """The method that fits a model and generates a motion from the given start."""

    def reproduce(demonstrations: Shown, start: Float64Array) -> Trajectory:
        motion: Trajectory = model.fit(demonstrations).generate(start=start)
        return motion

    return reproduce


def at_mean_duration(model: _Model) -> Method:
    """As `generated_by`, but the motion takes the mean duration of the demonstrations."""

    def reproduce(demonstrations: Shown, start: Float64Array) -> Trajectory:
        duration = np.mean([demonstration.motion.duration for demonstration in demonstrations])
        skill = model.fit(demonstrations)
        motion: Trajectory = skill.generate(start=start, duration=float(duration))
        return motion

    return reproduce


def nearest_shifted(demonstrations: Shown, start: Float64Array) -> Trajectory:
    """The demonstration that starts nearest, shifted to the start; the shift fades to 0."""
    motions = [demonstration.motion for demonstration in demonstrations]
    assert all(isinstance(motion, Trajectory) for motion in motions)
    nearest = min(motions, key=lambda motion: float(np.linalg.norm(motion.positions[0] - start)))
    covered = arc_length(nearest.positions)
    left = 1.0 - covered / covered[-1]
    return Trajectory(
        nearest.times, nearest.positions + left[:, None] * (start - nearest.positions[0])
    )


# The settings for the sweep over saturations and for auto-learning.
SETTINGS = {
    "FML, paper's setting": paper_setting(),
    "FML": FastMarching(),
    "FML, map": FastMarching(method="map"),
}

METHODS: dict[str, Method] = {
    "FML, paper's setting": at_mean_duration(SETTINGS["FML, paper's setting"]),
    "FML, paper's setting, speed by F": at_mean_duration(paper_setting(timing="speed_map")),
    "FML": generated_by(SETTINGS["FML"]),
    "FML, map": generated_by(SETTINGS["FML, map"]),
    "FML, start": generated_by(FastMarching(method="start")),
    "FML, mean path": generated_by(FastMarching(method="mean_path")),
    "ProMP": generated_by(ProMP()),
    "GMR": generated_by(GMR(components=8)),
    "nearest demonstration, shifted": nearest_shifted,
}

# The paper's rivals by their names in the registry, with settings in the middle of those among
# which the comparison chooses. They learn from all demonstrations, as in the paper's Table 2.
SYSTEMS: dict[str, tuple[str, dict[str, int]]] = {
    "SEDS": ("seds", {"components": 6}),
    "CLF-DM": ("clf-dm", {"components": 8}),
    "FSM-DM": ("fsm-dm", {"units": 25}),
    "UMIC": ("umic", {"kernels": 50}),
    "Modified DS": ("modified-ds", {"units": 100}),
}


def system(name: str) -> _Model:
    """The model of a name in SYSTEMS."""
    entry, settings = SYSTEMS[name]
    made: _Model = model_entry(entry).load()(**settings)
    return made
