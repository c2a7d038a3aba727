"""Models of other libraries, with `fit` and `generate` as the package's own models have them.

They see what our models see: demonstrations as they are, start and goal. Settings that a library
leaves to its user are chosen as for our models: time runs from 0 to 1 in each demonstration,
columns are divided by their deviation, and a mean that does not begin at the start is shifted to
it, the shift fading along the path.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Literal, TypeAlias

import numpy as np

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.motion import Demonstration, PoseTrajectory, Trajectory
from leadthrough.preprocess.resample import arc_length
from leadthrough_studies.comparison.pushes import faded_rest, time_at
from leadthrough_studies.robotasks.methods import peer_primitive

Shown: TypeAlias = Sequence[Demonstration[Any]]
# Motion that a library has learned: columns (n, d), scaled, at the times, from start to goal.
Curve: TypeAlias = Callable[[Float64Array, Float64Array, Float64Array | None], Float64Array]
# How the offsets of a mean's ends fade along it; of "nothing" the ends stay where they are.
Fading: TypeAlias = Literal["path", "time", "nothing"]
# The same after a push at the first of the times, to the last argument's columns (d,).
PushedCurve: TypeAlias = Callable[
    [Float64Array, Float64Array, Float64Array | None, Float64Array], Float64Array
]

_SAMPLES = 201  # per demonstration and motion

# The libraries that the study compares with, as imported and as installed.
LIBRARIES = {
    "movement_primitives": "movement-primitives",
    "gmr": "gmr",
    "mp_pytorch": "mp_pytorch",
}
# MP_PyTorch needs PyTorch, but does not say so when it is installed.
MISSING = tuple(
    package
    for module, package in LIBRARIES.items()
    if not find_spec(module) or (module == "mp_pytorch" and not find_spec("torch"))
)
# The name under which a peer stands with the one setting that is best for all sets of recordings.
AT_ITS_BEST = "movement_primitives, best ProMP"
NOT_INSTALLED = "Left out, as not installed: {}; pip install 'leadthrough[rivals]'."


@dataclass(frozen=True, eq=False)
class RivalSkill:
    """A curve that another library has learned.

    Attributes:
        curve: of the library.
        middle: (d,), taken off the columns.
        scale: (d,), divisors of the columns.
        duration: mean duration of the demonstrations, s.
        pushed_curve: the library's own continuation after a push; None where it has none.
    """

    curve: Curve
    middle: Float64Array
    scale: Float64Array
    duration: float
    pushed_curve: PushedCurve | None = None

    def generate(self, *, start: Any, goal: Any = None) -> Trajectory:
        """The motion from a start to a goal, or to where the demonstrations end."""
        times = np.linspace(0.0, 1.0, _SAMPLES)
        columns = self.curve(times, self._scaled(start), self._end(goal))
        return Trajectory(self.duration * times, columns * self.scale + self.middle)

    def pushed(self, *, start: Any, goal: Any, at: float, place: Any) -> Float64Array:
        """Positions (n, d) after a push; without a call of the library's, the push's offset fades.

        Arguments are those of `pushes.after_push`.
        """
        own = self.generate(start=start, goal=goal)
        if self.pushed_curve is None:
            return faded_rest(own, at, place)
        times = np.linspace(time_at(own, at) / self.duration, 1.0, _SAMPLES)
        ends = self._scaled(start), self._end(goal)
        columns = self.pushed_curve(times, *ends, self._scaled(place))
        return np.vstack([place, columns[1:] * self.scale + self.middle])

    def _scaled(self, position: Any) -> Float64Array:
        return np.asarray((np.asarray(position) - self.middle) / self.scale)

    def _end(self, goal: Any) -> Float64Array | None:
        return None if goal is None else self._scaled(goal)


def _columns(shown: Shown) -> tuple[Float64Array, Float64Array, Float64Array, float]:
    """Scaled columns (m, n, d) at evenly spaced times, their middle and scale, mean duration."""
    at = np.linspace(0.0, 1.0, _SAMPLES)
    curves = []
    for each in shown:
        phases = (each.motion.times - each.motion.times[0]) / each.motion.duration
        curves.append(np.stack([np.interp(at, phases, x) for x in each.motion.positions.T], axis=1))
    every = np.array(curves)
    middle, scale = every.mean(axis=(0, 1)), every.std(axis=(0, 1))
    scale = np.maximum(scale, 1e-3 * scale.max())
    duration = float(np.mean([each.motion.duration for each in shown]))
    return (every - middle) / scale, middle, scale, duration


def _shifted(
    mean: Float64Array, start: Float64Array, goal: Float64Array, by: Fading = "path"
) -> Float64Array:
    """A curve (n, d) with the offsets of its ends, which fade along its path or evenly in time."""
    if by == "nothing":
        return mean
    covered = np.linspace(0.0, 1.0, len(mean)) if by == "time" else arc_length(mean)
    rise = (covered / covered[-1])[:, None]
    return np.asarray(mean + (1.0 - rise) * (start - mean[0]) + rise * (goal - mean[-1]))


@dataclass(frozen=True)
class TimeRegression:
    """Regression with a Gaussian mixture of time and columns, by the library gmr.

    Attributes:
        components: number of components.
    """

    components: int = 10

    def fit(self, demonstrations: Shown) -> RivalSkill:
        """The mixture by the library's own expectation maximisation."""
        with warnings.catch_warnings(action="ignore"):  # of escapes in its sources
            import gmr  # noqa: PLC0415 - an optional peer

        curves, middle, scale, duration = _columns(demonstrations)
        times = np.linspace(0.0, 1.0, _SAMPLES)
        points = np.concatenate([np.column_stack([times, each])[::2] for each in curves])
        mixture = gmr.GMM(self.components, random_state=0)
        mixture.from_samples(points, init_params="kmeans++")
        end = curves[:, -1].mean(axis=0)

        def curve(at: Float64Array, start: Float64Array, goal: Float64Array | None) -> Float64Array:
            mean = np.asarray(mixture.predict(np.array([0]), at[:, None]))
            return _shifted(mean, start, end if goal is None else goal)

        return RivalSkill(curve, middle, scale, duration)


@dataclass(frozen=True)
class ConditionedPrimitive:
    """The probabilistic primitive of the library movement_primitives, conditioned on the ends.

    A mean that is conditioned exactly on ends unlike those demonstrated runs away in between, so
    that the ends' variance is a setting; what is left to them is shifted. Without conditioning the
    mean is only shifted, which is also what conditioning makes of a mean that was shifted before.

    Attributes:
        weights: number of weights per column.
        variance: of the ends, as a fraction of the columns' own; infinite: not conditioned.
        shift: how the offsets that are left to the ends fade.
    """

    weights: int = 20
    variance: float = 1e-2
    shift: Fading = "path"

    def fit(self, demonstrations: Shown) -> RivalSkill:
        """The distribution by the library's own expectation maximisation."""
        from movement_primitives.promp import ProMP  # noqa: PLC0415 - an optional peer

        curves, middle, scale, duration = _columns(demonstrations)
        times = np.linspace(0.0, 1.0, _SAMPLES)
        size = curves.shape[2]
        primitive = ProMP(size, self.weights)
        primitive.imitate(np.tile(times, (len(curves), 1)), curves)
        end = curves[:, -1].mean(axis=0)

        known_to = min(self.variance, 1.0) * np.eye(size)

        def conditioned(start: Float64Array, goal: Float64Array | None) -> ProMP:
            if np.isinf(self.variance):
                return primitive
            found = primitive.condition_position(start, known_to, t=0.0)
            return found if goal is None else found.condition_position(goal, known_to, t=1.0)

        def curve(at: Float64Array, start: Float64Array, goal: Float64Array | None) -> Float64Array:
            mean = np.asarray(conditioned(start, goal).mean_trajectory(at.copy()))
            return _shifted(mean, start, end if goal is None else goal, self.shift)

        def pushed(
            at: Float64Array, start: Float64Array, goal: Float64Array | None, place: Float64Array
        ) -> Float64Array:
            found = conditioned(start, goal).condition_position(place, known_to, t=float(at[0]))
            mean = np.asarray(found.mean_trajectory(at.copy()))
            return _shifted(mean, place, end if goal is None else goal, self.shift)

        return RivalSkill(curve, middle, scale, duration, pushed)


@dataclass(frozen=True)
class ProDMP:
    """The primitive of MP_PyTorch that is both probabilistic and dynamic.

    It begins at the start with the demonstrations' mean velocity. Its goal is moved by as much as
    the motion would miss the goal asked for.

    Attributes:
        weights: number of weights per column.
        nearest: of the demonstration with the nearest ends, or the mean of all.

    Source: Li and others, 2023, "ProDMP: a unified perspective on dynamic and probabilistic
    movement primitives"; settings as in the library's own demonstrations.
    """

    weights: int = 25
    nearest: bool = False

    def fit(self, demonstrations: Shown) -> RivalSkill:
        """Weights and goals by the library's regression, one set per demonstration."""
        import torch  # noqa: PLC0415 - an optional peer

        torch.set_num_threads(1)  # as all others
        curves, middle, scale, duration = _columns(demonstrations)
        primitive = self._primitive(curves.shape[2], torch.float64)
        every = torch.as_tensor(curves)
        times = torch.linspace(0.0, 1.0, _SAMPLES, dtype=torch.float64).expand(len(curves), -1)
        found = primitive.learn_mp_params_from_trajs(times, every)
        params, speeds = found["params"].numpy(), found["init_vel"].numpy()
        ends = curves[:, -1].mean(axis=0)

        def weights(start: Float64Array, goal: Float64Array | None) -> tuple[Any, Any]:
            chosen = slice(None)
            if self.nearest:
                apart = np.linalg.norm(curves[:, 0] - start, axis=1)
                if goal is not None:
                    apart = apart + np.linalg.norm(curves[:, -1] - goal, axis=1)
                chosen = slice(int(apart.argmin()), int(apart.argmin()) + 1)
            own, speed = params[chosen].mean(axis=0), speeds[chosen].mean(axis=0)
            made = self._made(primitive, np.linspace(0.0, 1.0, _SAMPLES), own, start, speed)
            moved = own.reshape(len(start), -1).copy()
            moved[:, -1] += (ends if goal is None else goal) - made[-1]
            return moved.ravel(), speed

        def curve(at: Float64Array, start: Float64Array, goal: Float64Array | None) -> Float64Array:
            own, speed = weights(start, goal)
            return self._made(primitive, at, own, start, speed)

        def pushed(
            at: Float64Array, start: Float64Array, goal: Float64Array | None, place: Float64Array
        ) -> Float64Array:
            own, speed = weights(start, goal)
            whole = np.linspace(0.0, 1.0, _SAMPLES)
            rates = np.gradient(self._made(primitive, whole, own, start, speed), whole, axis=0)
            now = np.array([np.interp(at[0], whole, each) for each in rates.T])
            return self._made(primitive, at, own, place, now, begun=float(at[0]))

        return RivalSkill(curve, middle, scale, duration, pushed)

    def _primitive(self, size: int, dtype: Any) -> Any:
        from mp_pytorch.mp import MPFactory  # noqa: PLC0415 - an optional peer

        settings = {
            "num_basis": self.weights,
            "basis_bandwidth_factor": 2,
            "num_basis_outside": 0,
            "alpha": 25,
            "alpha_phase": 2,
            "dt": 1.0 / (_SAMPLES - 1),
            "auto_scale_basis": True,
        }
        return MPFactory.init_mp("prodmp", settings, num_dof=size, tau=1.0, dtype=dtype)

    @staticmethod
    def _made(
        primitive: Any,
        at: Float64Array,
        params: Float64Array,
        start: Float64Array,
        speed: Any,
        *,
        begun: float = 0.0,
    ) -> Float64Array:
        import torch  # noqa: PLC0415 - an optional peer

        given = [
            torch.as_tensor(each)[None] for each in (at, params, np.array(begun), start, speed)
        ]
        return np.asarray(primitive.get_traj_pos(*given)[0].numpy())


@dataclass(frozen=True)
class CartesianPrimitive:
    """The Cartesian primitive of movement_primitives, of the demonstration with nearest ends."""

    def fit(self, demonstrations: Shown) -> CartesianPrimitive._Skill:
        """Skill that holds the demonstrations."""
        return self._Skill(demonstrations)

    @dataclass(frozen=True)
    class _Skill:
        shown: Shown

        def generate(self, *, start: Any, goal: Any) -> PoseTrajectory:
            """The primitive's motion from pose to pose."""
            return peer_primitive(self.shown, start, goal)

        def pushed(self, *, start: Any, goal: Any, at: float, place: Any) -> Float64Array:
            """Positions after a push, whose offset fades along the rest."""
            return faded_rest(self.generate(start=start, goal=goal), at, place)


@dataclass(frozen=True)
class OfPoses:
    """A model of columns that learns poses: positions and rotation vectors from the goal.

    The rotation vectors are those from the demonstrations' mean orientation at the goal, continued
    along each demonstration, as the package's own models have them.

    Attributes:
        columns: the model.
    """

    columns: Any  # one of the models of this module

    def fit(self, demonstrations: Shown) -> OfPoses._Skill:
        """The model of the columns."""
        motions = [each.motion for each in demonstrations]
        middle = rotations.mean(np.stack([each.orientations[-1] for each in motions]))
        vectors = [_vectors(each.orientations, middle) for each in motions]
        shown = [
            Demonstration(Trajectory(each.times, np.hstack([each.positions, turned])))
            for each, turned in zip(motions, vectors, strict=True)
        ]
        starts = np.mean([each[0] for each in vectors], axis=0)
        return self._Skill(self.columns.fit(shown), middle, starts)

    @dataclass(frozen=True, eq=False)
    class _Skill:
        columns: Any
        middle: Float64Array
        starts: Float64Array

        def generate(self, *, start: Any, goal: Any) -> PoseTrajectory:
            """The motion from pose to pose."""
            first, last = self._of(start, self.starts), self._of(goal, np.zeros(3))
            made = self.columns.generate(start=first, goal=last)
            middle = np.tile(self.middle, (len(made.times), 1))
            turned = rotations.compose(middle, rotations.exp(made.positions[:, 3:]))
            return PoseTrajectory(made.times, made.positions[:, :3], rotations.align_signs(turned))

        def pushed(self, *, start: Any, goal: Any, at: float, place: Any) -> Float64Array:
            """Positions after a push, by the columns' model."""
            first, last = self._of(start, self.starts), self._of(goal, np.zeros(3))
            tool = self._of(place, (1.0 - at) * self.starts)
            made = self.columns.pushed(start=first, goal=last, at=at, place=tool)
            return np.asarray(made[:, :3])

        def _of(self, pose: Any, near: Float64Array) -> Float64Array:
            """The columns (6,) of a pose, its rotation vector near another."""
            position, turned = pose
            return np.concatenate(
                [position, _nearest(_vectors(turned[None], self.middle)[0], near)]
            )


def _vectors(orientations: Float64Array, middle: Float64Array) -> Float64Array:
    """Rotation vectors (n, 3) from an orientation, continued from the last sample backwards."""
    middles = np.tile(middle, (len(orientations), 1))
    back = rotations.compose(rotations.inverse(middles), orientations)
    return np.asarray(rotations.lift(back[::-1])[::-1])


def _nearest(vector: Float64Array, near: Float64Array) -> Float64Array:
    """The rotation vector of the same rotation that is nearest to another vector."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-9:
        return vector
    turns = np.arange(-1, 2)[:, None]
    every = vector * (1.0 + 2.0 * np.pi * turns / angle)
    return np.asarray(every[np.linalg.norm(every - near, axis=1).argmin()])
