"""Probabilistic models against their peers: ProMP, Gaussian mixtures and the regression with them.

Twenty demonstrations of seven joints have 200 samples each. The error of a fit is how far its mean
and standard deviation are from those of the demonstrations; it must not exceed the peer's. Ours
estimates the deviation of the family that they come from, with n - 1, the peer theirs, with n. Ours
returns full covariances, the peer variances. Handwriting is predicted from the start of a
demonstration that was left out; the error is our area between the curves over the peer's.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from frame import Benchmark
from gmr import GMM
from movement_primitives.promp import ProMP as PeerProMP
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture

import leadthrough as lt
from leadthrough.models import Mixture, ProMPSkill, fit_mixture, trace_mixture
from leadthrough.preprocess.resample import arc_length
from leadthrough_studies.lasa.methods import generated_by
from leadthrough_studies.lasa.study import error_columns, splits

SAMPLES, JOINTS, WEIGHTS, COMPONENTS = 200, 7, 10, 10
DRAWINGS = ("Sshape", "JShape")
WEIGHTS_DRAWN, COMPONENTS_DRAWN = 20, 8  # those of our models by default
# The peer's iterations take long enough to measure, and few enough to converge to the same.
ITERATIONS = 30


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for all models; quick leaves out fewer drawings."""
    u, curves = _curves(20)
    yield from _promp(u, curves)
    yield from _mixture(u, curves)
    yield from _handwriting(DRAWINGS[:1] if quick else DRAWINGS)


def _promp(u: Any, curves: Any) -> Iterator[Benchmark]:
    shown = [lt.Demonstration(lt.JointTrajectory(u, each)) for each in curves]
    model = lt.ProMP(weights=WEIGHTS)

    def peer_fit() -> PeerProMP:
        promp = PeerProMP(JOINTS, WEIGHTS)
        promp.imitate(np.tile(u, (len(curves), 1)), curves)
        return promp

    skill, promp = model.fit(shown), peer_fit()
    yield Benchmark(
        f"ProMP: fit of {len(curves)} demonstrations; our error over the peer's",
        ours=lambda: model.fit(shown),
        peer=peer_fit,
        peer_name="movement_primitives",
        error=lambda a, b: (
            _misfit(_mean_and_deviation(a, u), curves, ddof=1)
            / _misfit(_peer_mean_and_deviation(b, u), curves, ddof=0)
        ),
        tolerance=1.0,
    )
    noise = 1e-6 * np.eye(JOINTS)
    for count in (1, 5):
        samples = np.linspace(20, 180, count + 2).astype(int)[1:-1]
        vias = curves.mean(axis=0)[samples] + 0.01
        yield Benchmark(
            f"ProMP: 100 times conditioned on {count} via point{'s' if count > 1 else ''}",
            ours=partial(_conditioned, skill, u[samples], vias, noise),
            peer=partial(_peer_conditioned, promp, u[samples], vias, noise),
            peer_name="movement_primitives",
            error=lambda a, b, at=samples, vias=vias: max(
                np.abs(a.distribution(u[at])[0] - vias).max(),
                np.abs(b.mean_trajectory(u.copy())[at] - vias).max(),
            ),
            tolerance=1e-2,
        )
    yield Benchmark(
        f"ProMP: mean and covariances at {SAMPLES} times, peer variances only",
        ours=lambda: skill.distribution(u),
        peer=lambda: (promp.mean_trajectory(u.copy()), promp.var_trajectory(u.copy())),
        peer_name="movement_primitives",
        error=lambda a, b: np.abs(a[0] - b[0]).max() / np.ptp(curves),
        tolerance=0.02,
    )


def _conditioned(skill: ProMPSkill, times: Any, vias: Any, noise: Any) -> Any:
    for _ in range(100):
        found = skill.condition(times, vias, covariance=noise)
    return found


def _peer_conditioned(promp: PeerProMP, times: Any, vias: Any, noise: Any) -> PeerProMP:
    for _ in range(100):
        found = promp
        for time, via in zip(times, vias, strict=True):
            found = found.condition_position(via, noise, t=time)
    return found


def _mixture(u: Any, curves: Any) -> Iterator[Benchmark]:
    points = np.concatenate([np.column_stack([u, each]) for each in curves])
    points = (points - points.mean(axis=0)) / points.std(axis=0)
    (first,) = trace_mixture(points, COMPONENTS, iterations=0)
    yield Benchmark(
        f"GMM: {ITERATIONS} iterations of EM, {len(points)} points of 8 columns, K = {COMPONENTS}",
        ours=lambda: trace_mixture(points, first, iterations=ITERATIONS)[-1],
        peer=lambda: _peer_em(points, first),
        peer_name="scikit-learn",
        error=lambda a, b: abs(float(a.log_density(points).mean()) - b.score(points)),
        tolerance=2e-2,
    )
    mixture = fit_mixture(points, COMPONENTS, starts=1).mixture
    peer = GMM(COMPONENTS, mixture.weights, mixture.means, mixture.covariances)
    times = np.linspace(points[:, 0].min(), points[:, 0].max(), SAMPLES)
    yield Benchmark(
        f"GMR: mean and covariance at {SAMPLES} times",
        ours=lambda: mixture.regress(times[:, None], inputs=[0]),
        peer=lambda: _peer_regression(peer, times),
        peer_name="gmr",
        error=lambda a, b: max(np.abs(a[0] - b[0]).max(), np.abs(a[1] - b[1]).max()),
        tolerance=1e-8,
    )


def _handwriting(motions: Sequence[str]) -> Iterator[Benchmark]:
    for name, model, peer, peer_name in (
        ("ProMP", lt.ProMP(), _peer_promp, "movement_primitives"),
        ("GMR", lt.GMR(8, starts=1), _peer_gmr, "gmr"),
    ):
        yield Benchmark(
            f"{name}: {7 * len(motions)} drawings left out; our area over the peer's",
            ours=partial(_areas, motions, generated_by(model)),
            peer=partial(_areas, motions, peer),
            peer_name=peer_name,
            error=lambda a, b: a / b,
            tolerance=1.02,  # regressions with the same mixture differ by a rounding
        )


def _areas(motions: Sequence[str], method: Any) -> float:
    """The mean swept area over the left-out drawings, mm^2."""
    rng = np.random.default_rng(0)
    areas = [
        error_columns(tested, method(shown, tested.positions[0]))["SEA_mm2"]
        for name in motions
        for shown, tested in splits(lt.io.lasa.load(name), 6, rng)
    ]
    return float(np.mean(areas))


def _peer_promp(shown: Any, start: Any) -> lt.Trajectory:
    duration, times, curves = _sampled(shown)
    promp = PeerProMP(2, WEIGHTS_DRAWN)
    promp.imitate(np.tile(times, (len(curves), 1)), curves)
    conditioned = promp.condition_position(start, 1e-8 * np.eye(2), t=0.0)
    return lt.Trajectory(duration * times, conditioned.mean_trajectory(times.copy()))


def _peer_gmr(shown: Any, start: Any) -> lt.Trajectory:
    """A mean fitted by scikit-learn, as gmr's own EM is slow, moved to the start as ours is."""
    duration, times, curves = _sampled(shown)
    points = np.concatenate([np.column_stack([times, each]) for each in curves])
    middle, scale = points.mean(axis=0), points.std(axis=0)
    fit = GaussianMixture(COMPONENTS_DRAWN, random_state=0).fit((points - middle) / scale)
    mixture = GMM(COMPONENTS_DRAWN, fit.weights_, fit.means_, fit.covariances_)
    asked = (times[:, None] - middle[0]) / scale[0]
    mean = mixture.predict(np.array([0]), asked) * scale[1:] + middle[1:]
    covered = arc_length(mean)
    covered = (covered / covered[-1])[:, None]
    offsets = start - mean[0], curves[:, -1].mean(axis=0) - mean[-1]
    return lt.Trajectory(
        duration * times, mean + (1.0 - covered) * offsets[0] + covered * offsets[1]
    )


def _sampled(shown: Any) -> tuple[float, Any, Any]:
    """Mean duration, evenly spaced phases (200,) and the drawings at them (m, 200, 2)."""
    times = np.linspace(0.0, 1.0, SAMPLES)
    curves = [
        [np.interp(times, _phases(each.motion), column) for column in each.motion.positions.T]
        for each in shown
    ]
    duration = float(np.mean([each.motion.duration for each in shown]))
    return duration, times, np.array(curves).transpose(0, 2, 1)


def _phases(motion: lt.Trajectory) -> Any:
    """Times of the samples from 0 to 1."""
    return (motion.times - motion.times[0]) / motion.duration


def _curves(count: int) -> tuple[Any, Any]:
    """Evenly spaced phases (200,) and random smooth variations (count, 200, 7) of a motion."""
    rng = np.random.default_rng(0)
    u = np.linspace(0.0, 1.0, SAMPLES)
    waves = np.stack([np.ones(SAMPLES), u, np.sin(np.pi * u), np.sin(2 * np.pi * u)])
    middle = rng.standard_normal((JOINTS, 4))
    amplitudes = middle + 0.2 * rng.standard_normal((count, JOINTS, 4))
    return u, np.einsum("mjk,kn->mnj", amplitudes, waves)


def _mean_and_deviation(skill: Any, u: Any) -> tuple[Any, Any]:
    mean, covariance = skill.distribution(u)
    return mean, np.sqrt(np.einsum("nii->ni", covariance))


def _peer_mean_and_deviation(promp: PeerProMP, u: Any) -> tuple[Any, Any]:
    return promp.mean_trajectory(u.copy()), np.sqrt(promp.var_trajectory(u.copy()))


def _misfit(fitted: tuple[Any, Any], curves: Any, *, ddof: int) -> float:
    """Root mean square error of a mean and of standard deviations with n - ddof."""
    own = curves.mean(axis=0), curves.std(axis=0, ddof=ddof)
    squares = [((a - b) ** 2).mean() for a, b in zip(fitted, own, strict=True)]
    return float(np.sqrt(np.sum(squares)))


def _peer_em(points: Any, first: Mixture) -> GaussianMixture:
    """The peer's fit from the same start, without its own clustering."""
    peer = GaussianMixture(
        COMPONENTS,
        max_iter=ITERATIONS,
        tol=0.0,
        init_params="random_from_data",
        weights_init=first.weights,
        means_init=first.means,
        precisions_init=np.linalg.inv(first.covariances),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return peer.fit(points)


def _peer_regression(peer: GMM, times: Any) -> tuple[Any, Any]:
    found = [peer.condition([0], [time]).to_mvn() for time in times]
    return np.stack([each.mean for each in found]), np.stack([each.covariance for each in found])
