"""The models that are compared, each with the settings among which inner cross-validation chooses.

A model joins with one line, by its name in the registry. Peers offer the same `fit` and
`generate`; libraries that are not installed are left out (`rivals.MISSING`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from leadthrough import rotations
from leadthrough.errors import LeadthroughError
from leadthrough.models import model_entry
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import arc_length
from leadthrough_studies.comparison.pushes import faded_rest, time_at
from leadthrough_studies.comparison.recordings import Chosen
from leadthrough_studies.comparison.rivals import (
    AT_ITS_BEST,
    MISSING,
    CartesianPrimitive,
    ConditionedPrimitive,
    OfPoses,
    ProDMP,
    TimeRegression,
)

Shown: TypeAlias = Sequence[Demonstration]
# A model of the package, or what offers `fit` as they do; a skill with `generate`.
Model: TypeAlias = Any
# The error of a model on demonstrations that are left out; less is better.
Error: TypeAlias = Callable[[Model, Any], float]


@dataclass(frozen=True)
class NearestShifted:
    """The demonstration with the nearest ends, shifted to the start and the goal asked for."""

    def fit(self, demonstrations: Shown) -> NearestShifted._Skill:
        """Skill that holds the demonstrations."""
        return self._Skill([each.motion for each in demonstrations])

    @dataclass(frozen=True)
    class _Skill:
        motions: Sequence[Any]

        def generate(self, *, start: Any, goal: Any = None) -> Any:
            """The nearest motion; the offsets of its ends fade along it."""
            ends = [None if each is None else _position(each) for each in (start, goal)]

            def gap(motion: Any) -> float:
                pairs = zip(ends, motion.positions[[0, -1]], strict=True)
                return sum(
                    float(np.linalg.norm(end - shown)) for end, shown in pairs if end is not None
                )

            motion = min(self.motions, key=gap)
            covered = arc_length(motion.positions)
            rise = (covered / covered[-1])[:, None]
            moved = motion.positions.copy()
            for end, row, share in ((ends[0], 0, 1.0 - rise), (ends[1], -1, rise)):
                if end is not None:
                    moved = moved + share * (end - motion.positions[row])
            made = replace(motion, positions=moved)
            if not isinstance(motion, PoseTrajectory):
                return made
            turned = _turned(motion.orientations, rise, start, goal)
            return replace(made, orientations=turned)

        def pushed(self, *, start: Any, goal: Any, at: float, place: Any) -> Any:
            """Positions after a push, whose offset fades along the rest."""
            return faded_rest(self.generate(start=start, goal=goal), at, place)


def _position(place: Any) -> Any:
    pose = isinstance(place, tuple) and len(place) == 2 and np.ndim(place[0]) == 1
    return np.asarray(place[0] if pose else place)


def _turned(shown: Any, rise: Any, start: Any, goal: Any) -> Any:
    offsets = np.zeros((len(shown), 3))
    for place, row, share in ((start, 0, 1.0 - rise), (goal, -1, rise)):
        if place is not None:
            back = rotations.inverse(shown[[row]])
            offsets = offsets + share * rotations.log(rotations.compose(place[1][None], back))
    return rotations.align_signs(rotations.compose(rotations.exp(offsets), shown))


@dataclass(frozen=True)
class PeerPrimitive:
    """The movement primitive of the library movement_primitives, of the nearest demonstration.

    Attributes:
        weights: number of kernels per dimension.
    """

    weights: int = 50

    def fit(self, demonstrations: Shown) -> PeerPrimitive._Skill:
        """What holds the demonstrations: the primitive is fitted to the one whose ends are near."""
        return self._Skill([each.motion for each in demonstrations], self.weights)

    @dataclass(frozen=True)
    class _Skill:
        motions: Sequence[Any]
        weights: int

        def generate(self, *, start: Any, goal: Any = None) -> Trajectory:
            """The primitive's motion from the start to the goal."""
            return Trajectory(*self._primitive(start, goal).open_loop())

        def pushed(self, *, start: Any, goal: Any, at: float, place: Any) -> Any:
            """Positions after a push: the library's `step` goes on from the tool."""
            primitive = self._primitive(start, goal)
            own = Trajectory(*primitive.open_loop())
            primitive.reset()
            position, velocity = np.asarray(start, dtype=np.float64), np.zeros(len(start))
            now, path = time_at(own, at), [np.asarray(place)]
            while primitive.t < now:
                position, velocity = primitive.step(position, velocity)
            primitive.current_y = np.array(place)  # it takes no measured tool, but has its state
            while primitive.t < own.duration:
                position, velocity = primitive.step(path[-1], velocity)
                path.append(position)
            return np.array(path)

        def _primitive(self, start: Any, goal: Any) -> Any:
            from movement_primitives import dmp  # noqa: PLC0415 - an optional peer

            first = np.asarray(start)
            motion = min(
                self.motions, key=lambda each: float(np.linalg.norm(each.positions[0] - first))
            )
            size, count = motion.positions.shape[1], len(motion.times)
            times = np.linspace(0.0, motion.duration, count)
            primitive = dmp.DMP(size, motion.duration, times[1], n_weights_per_dim=self.weights)
            primitive.imitate(times, motion.positions)
            last = motion.positions[-1] if goal is None else np.asarray(goal)
            primitive.configure(start_y=first, goal_y=last)
            return primitive


@dataclass(frozen=True)
class AutoLearning:
    """Fast marching that learns its own paths from the demonstrations' starts, if kappa is low.

    Attributes:
        model: of fast marching.
        threshold: of kappa, by Prados et al. 2023.
    """

    model: Any
    threshold: float = 0.6

    def fit(self, demonstrations: Shown) -> Any:
        """The model's skill, with the paths that it has learned."""
        skill = self.model.fit(demonstrations)
        for each in demonstrations:
            path = skill.generate(start=each.motion.positions[0])
            skill = skill.auto_learn(path, threshold=self.threshold)
        return skill


def _of(name: str, *settings: Mapping[str, Any]) -> tuple[Model, ...]:
    """A registered model, with each of several settings; with none, as it is by default."""
    kind = model_entry(name).load()
    return tuple(kind(**each) for each in settings or ({},))


def _with(setting: str, *values: int, **others: Any) -> tuple[Mapping[str, Any], ...]:
    """Settings that differ in one value."""
    return tuple({setting: value, **others} for value in values)


# The dynamical systems.
SYSTEMS: dict[str, tuple[Model, ...]] = {
    "SEDS, likelihood": _of("seds", *_with("components", 4, 6, 8)),
    "SEDS, mean square": _of("seds", *_with("components", 4, 6, 8, objective="mse")),
    "LPV-DS": _of("lpv-ds"),
    "CLF-DM": _of("clf-dm", *_with("components", 6, 8, 12)),
    "FSM-DM": _of("fsm-dm", *_with("units", 15, 25, 40)),
    "UMIC": _of("umic", *_with("kernels", 30, 50)),
    "Modified DS": _of("modified-ds", *_with("units", 50, 100, 200)),
}

# Prados et al. 2023: 25 pixels and one cell a pixel, at 8.3 pixels per mm; in space cells of 1 cm.
_PAPER = {"area_of_influence": 25.0 / 8.3, "saturation": 0.1, "resolution": 1.0 / 8.3}
_PAPER_IN_SPACE = {"area_of_influence": 0.05, "saturation": 0.25, "resolution": 0.01}


def _papers(**settings: float) -> dict[str, tuple[Model, ...]]:
    """The paper's own method, without and with auto-learning."""
    models = _of("fast-marching", {**settings, "method": "map"})
    learning = tuple(AutoLearning(each) for each in models)
    return {"FML, paper's setting": models, "FML, auto-learning": learning}


# By name, for points. The package's own models stand at their defaults.
POINTS: dict[str, tuple[Model, ...]] = {
    "FastMarching": _of("fast-marching"),
    "AlignedMean": _of("aligned-mean"),
    **_papers(**_PAPER),
    "DMP": _of("dmp"),
    "ProMP": _of("promp"),
    "GMR": _of("gmr"),
    **SYSTEMS,
    "nearest demonstration, shifted": (NearestShifted(),),
}
_NEAREST = "movement_primitives, nearest demonstration"
# The least geometric mean of Frechet errors over the fifteen sets of recordings whose figures are
# printed, each demonstration left out: of 10 to 40 weights, variances of 1e-8 to 1 and none, and
# ends shifted along the path, evenly in time or not at all. No setting is best on all of them.
BEST_PEER = ConditionedPrimitive(weights=30, variance=3e-2, shift="path")
_RIVALS: dict[str, tuple[str, tuple[Model, ...]]] = {
    "movement_primitives, ProMP": (
        "movement-primitives",
        (
            *(
                ConditionedPrimitive(weights=weights, variance=variance)
                for weights, variance in ((10, 1e-8), (20, 1e-8), (20, 1e-2), (20, 1e-4))
            ),
            BEST_PEER,
        ),
    ),
    "gmr": ("gmr", tuple(TimeRegression(components=k) for k in (6, 10, 15))),
    "MP_PyTorch, ProDMP": (
        "mp_pytorch",
        (ProDMP(weights=10), ProDMP(weights=25), ProDMP(weights=25, nearest=True)),
    ),
}
_INSTALLED = {name: models for name, (package, models) in _RIVALS.items() if package not in MISSING}
if "movement-primitives" not in MISSING:
    POINTS[_NEAREST] = (PeerPrimitive(weights=20), PeerPrimitive(weights=50))
POINTS |= _INSTALLED

# For courses in m.
COURSES: dict[str, tuple[Model, ...]] = {**POINTS, **_papers(**_PAPER_IN_SPACE)}

# For poses. UMIC is left out: its constraint at samples says little in six dimensions.
POSES: dict[str, tuple[Model, ...]] = {
    "FastMarching": _of("fast-marching"),
    "AlignedMean": _of("aligned-mean"),
    "DMP": _of("dmp"),
    "ProMP": _of("promp"),
    "GMR": _of("gmr"),
    **{name: models for name, models in SYSTEMS.items() if name not in {"UMIC", "FSM-DM"}},
    "FSM-DM": _of("fsm-dm", *_with("units", 8, 15)),
    "nearest demonstration, shifted": (NearestShifted(),),
}
if "movement-primitives" not in MISSING:
    POSES[_NEAREST] = (CartesianPrimitive(),)
POSES |= {name: tuple(OfPoses(each) for each in models) for name, models in _INSTALLED.items()}

# For joints: the same without fast marching, which takes points and poses.
JOINTS: dict[str, tuple[Model, ...]] = {
    name: POINTS.get(name, models) for name, models in POSES.items() if name != "FastMarching"
}

# Models that lead a simulated arm: those of the package but the systems to avoid.
ONLINE = (
    "FastMarching",
    "AlignedMean",
    "DMP",
    "ProMP",
    "GMR",
    "SEDS, likelihood",
    "LPV-DS",
    "CLF-DM",
    "Modified DS",
)

# For sets of recordings, of points and of poses: what demonstrations of any kind can be given to.
RECORDED: dict[str, tuple[Model, ...]] = {
    "learn": (Chosen(),),
    **{name: models for name, models in POINTS.items() if name in POSES and name not in SYSTEMS},
}
RECORDED_POSES: dict[str, tuple[Model, ...]] = {
    name: POSES.get(name, models) for name, models in RECORDED.items()
}
if "movement-primitives" not in MISSING:
    RECORDED[AT_ITS_BEST] = (BEST_PEER,)
    RECORDED_POSES[AT_ITS_BEST] = (OfPoses(BEST_PEER),)


def chosen(models: Sequence[Model], shown: Shown, error: Error, *, folds: int) -> Model:
    """The model of several with the least error on demonstrations that are left out in turn.

    Args:
        models: at least one.
        shown: the demonstrations that may be learned from.
        error: of a model fitted to some demonstrations, on others.
        folds: number of demonstrations that are left out, spread over all; 0 takes the middle one
            of the models.
    """
    if len(models) == 1 or folds == 0 or len(shown) < 2:
        return models[len(models) // 2]
    left_out = np.linspace(0, len(shown) - 1, min(folds, len(shown))).round().astype(int)

    def total(model: Model) -> float:
        found = 0.0
        for i in left_out:
            try:
                skill = model.fit([each for j, each in enumerate(shown) if j != i])
            except LeadthroughError:
                return float("inf")
            found += error(skill, [shown[i]])
        return found

    return min(models, key=total)
