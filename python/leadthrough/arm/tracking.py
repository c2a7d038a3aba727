"""Joints along a path of the tip, sample after sample, without a jump.

Most branches of inverse kinematics end at a joint limit or at a singularity. So several initial
postures are followed ahead along a thinned path; the one that gets furthest is preferred, then the
one whose joints move slowly and stay away from their limits. An arm of fewer than six joints frees
the rotations about the tip's axes that give the smallest orientation error.

Demonstrated joints lead through singularities, beside which the exact path asks for large motions:
there the whole path is one least-squares problem, of the tip's errors and of the rates at which the
joints leave the demonstrated ones. Away from singularities the first vanish; beside them the tip
leaves the path a little. Levenberg-Marquardt steps solve it; their matrices are block tridiagonal.

Sources: Wampler 1986 and Nakamura and Hanafusa 1986 for the damping, which is of rates here;
Marquardt 1963.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.arm.ik_failure import failure
from leadthrough.arm.inverse_kinematics import Axis, free_axes, tolerance
from leadthrough.arm.limits import JointLimits, known_acceleration, margins
from leadthrough.arm.tip_path import CollisionTest, TipPath, Track, clear_path, solve_sample
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, IkFailure, InvalidInput
from leadthrough.noise import without_noise

_SAMPLE_ITERATIONS = 60
# Damping to try where the arm may leave the path, m^2 per rad^2: from none to (0.1 m per rad)^2,
# which halves the step of a joint that moves the tip by 0.1 m per rad.
_DAMPINGS = (0.0, 1e-5, 1e-4, 1e-3, 1e-2)
_ROTATIONS: tuple[Axis, ...] = ("rx", "ry", "rz")
# Configurations from which the first sample is solved. An arm with a wrist has up to eight
# postures, and more in which a joint has made a whole turn; a redundant arm has a curve of them.
_GUESSES = 48
# The first of them also lead to the point of their curve nearest to the middle of the ranges.
_CENTRED_GUESSES = 16
# Starts to return.
_MAX_STARTS = 24
# Two postures that differ by less than this in every joint are the same, rad or m.
_SAME_POSTURE = 1e-2
# Samples of the thinned path.
_LOOK_AHEAD = 40
# A joint this far from the demonstrated one, rad (m), may be in another branch.
_OTHER_BRANCH = 1.0
# Demonstrated joints this near to a path, m, are on it. A track that is this far from them, rad
# (m), or turns the tip by so much, rad, leaves them.
_ON_PATH, _LEAVES, _TURNED = 1e-3, 0.1, 1e-3
# Factor of the errors that are offered as tolerances: they are printed with two digits.
_WIDER = 1.1
# A joint this near to a limit, as a fraction of its range, costs as much as double speed.
_NEAR_A_LIMIT = 0.05


@dataclass(frozen=True, eq=False)
class Tracker:
    """Follows a path from given starts."""

    chain: core.Chain
    path: TipPath
    limits: JointLimits
    allowed: tuple[float, float]  # errors in m and rad that count as reached
    max_step: float  # of a joint between two samples, rad or m

    @property
    def tolerance(self) -> core.IkTolerance:
        return tolerance(*self.allowed)

    def along(self, start: Start) -> Track:
        """The track along the path, at whatever speed that takes."""
        return self._track(start, self.path)

    def in_time(self, start: Start, damping: float, deviation: tuple[float, float]) -> Track:
        """The track along the path at the path's own pace, inside the limits."""
        first = self._track(start, self.path.only(slice(1)))
        options = core.PursuitOptions(
            self.limits.velocity, known_acceleration(self.limits), damping, tolerance(*deviation)
        )
        columns = core.pursue(
            self.chain,
            self.path.times,
            self.path.positions,
            self.path.orientations,
            first.q[0],
            *self.path.pull(start.rate),
            options,
        )
        return Track.of(columns, deviation)

    def deviating(self, start: Start, deviation: tuple[float, float]) -> Track:
        """Of the tracks with several dampings, the one that stays nearest to the path."""
        tracks = []
        for damping in _DAMPINGS:
            tracks.append(self.in_time(start, damping, deviation))
            if _distance(tracks[-1], self.allowed) <= 1.0:
                break
        return min(tracks, key=lambda track: _rank(track, deviation))

    def searched(
        self, q0: Float64Array | None, around: CollisionTest | None
    ) -> Float64Array | None:
        """Joints (n, joints) found by looking ahead; None if there are none."""
        try:
            q = clear_path(self.chain, self.path, around, start=q0, tolerance=self.tolerance)
        except IkFailure as ended:
            if around is None:
                return None
            if ended.status != "jump":
                raise
            stuck = Track.standing(self.chain, self.path, ended.index, ended.q)
            raise failure(self.chain, self.limits, self.path, stuck, otherwise="jump") from None
        leaps = np.abs(np.diff(q, axis=0)).max(initial=0.0) > self.max_step
        return None if leaps else q

    def _track(self, start: Start, path: TipPath) -> Track:
        axes = free_axes(path.free)
        options = core.TrackOptions(self.tolerance, _SAMPLE_ITERATIONS, self.max_step, axes)
        pull = path.pull(start.rate)
        columns = core.track(self.chain, path.positions, path.orientations, start.q, *pull, options)
        return Track.of(columns, self.allowed)


def starts(
    tracker: Tracker, q0: Float64Array | None, rate: float, *, others: bool
) -> Iterator[Start]:
    """Initial postures: next to q0; without one, or as well, any."""
    chain, path = tracker.chain, tracker.path
    redundant = len(chain.joint_names) > path.dimension and rate > 0.0
    rates = (rate, 0.0) if redundant else (0.0,)  # with and without the pull towards postures
    if q0 is not None:
        (q,), *_ = solve_sample(chain, path, 0, q0[None], path.options())
        yield from (Start(q, pull) for pull in rates)
    if q0 is None or others:
        yield from _first_postures(tracker, rates)


def best_track(
    tracker: Tracker,
    starts: Iterable[Start],
    track_from: Callable[[Start], Track],
    deviation: tuple[float, float],
) -> Track:
    """The first track that reaches the end and stays on the path, else the best one."""
    best: Track | None = None
    for start in starts:
        track = track_from(start)
        if best is None or _rank(track, deviation) < _rank(best, deviation):
            best = track
        if best.reached == len(tracker.path) and _distance(best, tracker.allowed) <= 1.0:
            break
    assert best is not None
    return best


def branch_track(
    tracker: Tracker, q0: Float64Array, rate: float, allowed: tuple[float, float]
) -> Track:
    """The track near its path's postures, exact if it can be."""
    path = tracker.path
    initial = starts(tracker, q0, rate, others=False)
    exact = best_track(tracker, initial, tracker.along, tracker.allowed)
    complete = exact.reached == len(path)
    if complete and np.abs(exact.q - path.postures).max() <= _OTHER_BRANCH:
        return exact
    return _track_on_branch(tracker.chain, path, allowed, tracker.max_step)


def as_demonstrated(
    tracker: Tracker, track: Track, *, leaving: tuple[float, float], ending: tuple[float, float]
) -> Track:
    """The track, or one near the path's postures if it leaves them without need, or ends."""
    # Beside a singularity an exact path may take joints far away for some micrometres.
    path, ends = tracker.path, track.reached < len(tracker.path)
    if not len(path.orientations) or (not ends and not _leaves(tracker.chain, path, track)):
        return track
    near = _track_on_branch(tracker.chain, path, ending if ends else leaving, tracker.max_step)
    return near if near.reached == len(path) else track


def _leaves(chain: core.Chain, path: TipPath, track: Track) -> bool:
    """Whether a track goes far from its path's postures though these are on the path."""
    if np.abs(_errors(chain, path, path.postures)).max() > _ON_PATH:
        return False
    away = np.abs(track.q - path.postures).max()
    return bool(away > _LEAVES or _orientation_error(chain, path, track) > _TURNED)


def off_branch(track: Track) -> str:
    """How far a track near demonstrated joints is from its path, and how to allow that."""
    far, angle = (
        f"{_WIDER * error.max():.2g}" for error in (track.position_errors, track.orientation_errors)
    )
    return (
        f"near the demonstrated joints the tip misses its path by up to {far} m and {angle} rad: "
        f"--tolerance {far},{angle} allows that; in Python, FollowOptions("
        f"position_tolerance={far}, orientation_tolerance={angle})"
    )


def _rank(track: Track, unit: tuple[float, float]) -> tuple[int, float]:
    return -track.reached, _distance(track, unit)


def _distance(track: Track, unit: tuple[float, float]) -> float:
    return float(
        max(track.position_errors.max() / unit[0], track.orientation_errors.max() / unit[1])
    )


def axes_to_try(
    path: TipPath, free: Collection[Axis] | None, *, joints: int, in_time: bool
) -> list[tuple[Axis, ...]]:
    """The choices of axes to leave free along a path, that of none first."""
    if free is not None:
        free_axes(free)
        if free and in_time:
            raise InvalidInput(
                "free: not used with on_rate_limit='deviate' or 'raise'; leave it out"
            )
        if not len(path.orientations) and (set(free) & set(_ROTATIONS) or set(free) >= set("xyz")):
            raise check.refused("free", "one or two of 'x', 'y', 'z' along points", list(free))
        return [tuple(free)]
    missing = min(6 - joints, len(_ROTATIONS)) if len(path.orientations) else 0
    if missing <= 0 or in_time:
        return [()]
    return list(dict.fromkeys([(), *combinations(_ROTATIONS, missing), _ROTATIONS]))


def least_rotated(chain: core.Chain, path: TipPath, tracks: Sequence[Track]) -> Track:
    """Of tracks with different axes free, the furthest, then that of least orientation error."""
    if len(tracks) == 1:
        return tracks[0]
    return min(tracks, key=lambda track: (-track.reached, _orientation_error(chain, path, track)))


def _orientation_error(chain: core.Chain, path: TipPath, track: Track) -> float:
    """The largest angle between the tip and a sample, rad."""
    _, orientations = chain.forward_kinematics(track.q)
    errors = rotations.distance(orientations, path.orientations[: len(orientations)])
    return float(np.max(errors))


@dataclass(frozen=True, eq=False)
class Start:
    q: Float64Array  # (joints,) at the first sample
    rate: float  # of the motion towards the preferred postures from there, 1/s


def _first_postures(tracker: Tracker, rates: Sequence[float]) -> list[Start]:
    """Starts for the path, the most promising first; at least one."""
    chain, path = tracker.chain, tracker.path
    postures, reached = _solutions(chain, path)
    starts = [Start(q, pull) for q in postures for pull in rates]
    if not reached or len(starts) == 1:
        return starts[:1]
    samples = np.unique(np.linspace(0, len(path) - 1, _LOOK_AHEAD).round().astype(int))
    thin = path.only(samples)
    stride, axes = math.ceil(len(path) / _LOOK_AHEAD), free_axes(path.free)
    step = tracker.max_step * stride
    options = core.TrackOptions(tracker.tolerance, _SAMPLE_ITERATIONS, step, axes)
    pulls = {rate: thin.pull(rate) for rate in rates}
    steps = np.diff(thin.times)[:, None]
    keys = []
    for i, start in enumerate(starts):
        pull = pulls[start.rate]
        q, *_ = core.track(chain, thin.positions, thin.orientations, start.q, *pull, options)
        keys.append((-len(q), _cost(chain, q, steps, tracker.limits.velocity), i))
    return [starts[i] for *_, i in sorted(keys)[:_MAX_STARTS]]


def _solutions(chain: core.Chain, path: TipPath) -> tuple[Float64Array, bool]:
    starts = guesses(chain)
    q, status, errors = solve_sample(chain, path, 0, starts, path.options())
    if not (status == 0).any():
        return q[[np.argmin(errors)]], False
    centred, its_status, _ = solve_sample(
        chain, path, 0, starts[:_CENTRED_GUESSES], path.options(nullspace_gain=1.0)
    )
    return _distinct(np.vstack([q[status == 0], centred[its_status == 0]])), True


def guesses(chain: core.Chain) -> Float64Array:
    """Configurations (m, joints) all over the joints' ranges, the middle first."""
    lower = np.maximum(chain.lower, -np.pi)
    upper = np.minimum(chain.upper, np.pi)
    samples = np.random.default_rng(0).uniform(0.0, 1.0, (_GUESSES - 1, len(lower)))
    return np.vstack([chain.middle, lower + samples * (upper - lower)])


def _distinct(q: Float64Array) -> Float64Array:
    distinct = q[:1]
    for row in q[1:]:
        if (np.abs(distinct - row).max(axis=1) > _SAME_POSTURE).all():
            distinct = np.vstack([distinct, row])
    return distinct


def _cost(chain: core.Chain, q: Float64Array, steps: Float64Array, velocity: Float64Array) -> float:
    """The largest joint speed over its limit, higher where joints come near position limits."""
    limit = np.where(np.isfinite(velocity) & (velocity > 0), velocity, 1.0)
    speeds = np.abs(np.diff(q, axis=0)) / steps[: len(q) - 1] / limit
    margin = margins(chain.lower, chain.upper, q).min()
    return float(speeds.max(initial=0.0)) * (1.0 + _NEAR_A_LIMIT / max(float(margin), 1e-9))


# m per rad: through a singularity of the wrist the tip turns, and hardly moves, off its path.
_PER_RADIAN = 0.1
# A joint that leaves the demonstrated rates by 1 rad/s (m/s) costs as much as 3 mrad of the tip to
# begin with, which converges from far away, and a tenth of that in the end, unless the joints leap
# then; m^2 s^2/rad^2.
_RATE_COSTS = (1e-7, 1e-8, 1e-9)
_ITERATIONS = 30
_CONVERGED = 1e-7  # rad or m of a step
_MIN_DAMPING, _MAX_DAMPING, _DAMPING_STEP = 1e-12, 1e3, 10.0
_HELD = 1e9  # damping of a joint at its limit


def _track_on_branch(
    chain: core.Chain, path: TipPath, allowed: tuple[float, float], max_step: float
) -> Track:
    """The track near a path's postures, all samples, with errors as small as these allow."""
    path = replace(path, postures=without_noise(path.postures))
    q = closer = np.ascontiguousarray(np.clip(path.postures, chain.lower, chain.upper))
    for cost in _RATE_COSTS:
        closer = _Branch(chain, path, cost).solve(closer)
        if np.abs(np.diff(closer, axis=0)).max(initial=0.0) > max_step:
            break
        q = closer
    errors = _errors(chain, path, q)
    far = np.linalg.norm(errors[:, :3], axis=1)
    angles = np.linalg.norm(errors[:, 3:], axis=1) / _PER_RADIAN
    missed = (far > allowed[0]) | (angles > allowed[1])
    return Track(q, far, angles, int(np.argmax(missed)) if missed.any() else len(q))


def _errors(chain: core.Chain, path: TipPath, q: Float64Array) -> Float64Array:
    """Errors (n, 6) of the tip, m, rotations weighted."""
    positions, orientations = chain.forward_kinematics(q)
    turns = rotations.compose(path.orientations, rotations.inverse(orientations))
    return np.hstack([path.positions - positions, _PER_RADIAN * rotations.log(turns)])


@dataclass(frozen=True, eq=False)
class _Branch:
    """The least-squares problem of a path."""

    chain: core.Chain
    path: TipPath
    rate_cost: float  # m^2 s^2

    @cached_property
    def _weights(self) -> Float64Array:
        """Of the samples' errors (n,), s."""
        return np.abs(np.gradient(self.path.times))

    @cached_property
    def _stiffness(self) -> Float64Array:
        """Of the steps from sample to sample (n - 1,)."""
        return self.rate_cost / np.diff(self.path.times)

    def solve(self, q: Float64Array) -> Float64Array:
        """The configurations (n, joints) of least cost that are reached from q."""
        damping, cost = _MIN_DAMPING, self._cost(q)
        for _ in range(_ITERATIONS):
            step_of = self._steps(q)
            while damping < _MAX_DAMPING:
                moved = np.clip(q + step_of(damping), self.chain.lower, self.chain.upper)
                its_cost = self._cost(moved)
                if its_cost <= cost:
                    break
                damping *= _DAMPING_STEP
            else:
                return q
            converged = np.abs(moved - q).max() < _CONVERGED
            q, cost, damping = moved, its_cost, max(damping / _DAMPING_STEP, _MIN_DAMPING)
            if converged:
                break
        return q

    def _cost(self, q: Float64Array) -> float:
        steps = np.diff(q - self.path.postures, axis=0)
        errors = _errors(self.chain, self.path, q)
        return float(
            np.sum(self._weights[:, None] * errors**2) + np.sum(self._stiffness[:, None] * steps**2)
        )

    def _steps(self, q: Float64Array) -> Callable[[float], Float64Array]:
        """Maps a damping to a step (n, joints); joints at a limit that it would push stay."""
        samples, joints = q.shape
        jacobians = core.jacobian(self.chain, q).reshape(samples, 6, joints).copy()
        jacobians[:, 3:] *= _PER_RADIAN
        weighted = self._weights[:, None, None] * jacobians
        blocks = np.einsum("nij,nik->njk", weighted, jacobians)
        pull = np.einsum("nij,ni->nj", weighted, _errors(self.chain, self.path, q))
        tension = self._stiffness[:, None] * np.diff(q - self.path.postures, axis=0)
        pull[:-1] += tension
        pull[1:] -= tension
        held = (q <= self.chain.lower) & (pull < 0.0) | (q >= self.chain.upper) & (pull > 0.0)
        diagonal = np.zeros(samples)
        diagonal[:-1] += self._stiffness
        diagonal[1:] += self._stiffness
        bands = np.zeros((2 * joints, samples * joints))  # lower ones, by their distance
        for i in range(joints):
            for j in range(i + 1):
                bands[i - j, j::joints] = blocks[:, i, j]
            bands[0, i::joints] += diagonal + _HELD * held[:, i]
            bands[joints, i : (samples - 1) * joints : joints] = -self._stiffness
        right = np.where(held, 0.0, pull).ravel()
        return lambda damping: _solved_bands(bands, right, damping).reshape(samples, joints)


@one_blas_thread
def _solved_bands(bands: Float64Array, right: Float64Array, damping: float) -> Float64Array:
    """Solution of a damped symmetric positive definite system of these lower bands."""
    from scipy.linalg import solveh_banded

    damped = bands.copy()
    damped[0] += damping
    return np.asarray(solveh_banded(damped, right, lower=True, overwrite_ab=True))
