"""Fitted ProMPs: the distribution, motions, samples, likelihood, files."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput, UnsupportedQuery

TIMES = np.linspace(0.0, 2.0, 200)


def test_velocity_and_acceleration_are_derivatives_of_the_mean(skill):
    step = 1e-5
    inside = TIMES[1:-1]
    for order in (1, 2):
        ahead, _ = skill.distribution(inside + step, order=order - 1)
        behind, _ = skill.distribution(inside - step, order=order - 1)
        given, _ = skill.distribution(inside, order=order)
        np.testing.assert_allclose(given, (ahead - behind) / (2 * step), atol=1e-4)


def test_covariances_are_those_of_samples(skill):
    times = np.linspace(0.0, 2.0, 9)
    weights = skill.sample_weights(20_000, seed=1).reshape(20_000, 3, -1)
    for order in (0, 1, 2):
        rows = skill.basis(times / 2.0, order) / 2.0**order
        values = np.einsum("nk,mdk->mnd", rows, weights)
        _, covariance = skill.distribution(times, order=order)
        for i in range(len(times)):
            tolerance = 0.05 * np.abs(covariance[i]).max()
            np.testing.assert_allclose(np.cov(values[:, i].T), covariance[i], atol=tolerance)


def test_joint_motion_comes_with_names_and_derivatives(skill):
    motion = skill.generate(duration=4.0, dt=0.005)
    assert isinstance(motion, lt.JointTrajectory)
    assert motion.joint_names == ("a", "b", "c")
    gradient = np.gradient(motion.positions, motion.times, axis=0)
    np.testing.assert_allclose(motion.velocities[1:-1], gradient[1:-1], atol=1e-3)
    slope = np.gradient(motion.velocities, motion.times, axis=0)
    np.testing.assert_allclose(motion.accelerations[1:-1], slope[1:-1], atol=1e-2)


def test_samples_are_repeatable_and_of_the_type_shown(skill, shown):
    first, second = (skill.sample(3, seed=7) for _ in range(2))
    assert len(first) == 3
    for a, b in zip(first, second, strict=True):
        assert isinstance(a, lt.JointTrajectory)
        assert a.positions.tobytes() == b.positions.tobytes()
    assert skill.sample(1, seed=8)[0].positions.tobytes() != first[0].positions.tobytes()


def test_samples_too_fast_for_floats_are_refused(skill):
    huge = replace(skill.free, mean=1e307 * skill.free.mean)
    with pytest.raises(InvalidInput, match="velocities: expected finite"):
        skill.with_weights(huge).lasting(1e-6).sample(2, seed=0, dt=1e-7)


def test_likelihood_is_that_of_the_normal_distribution(shown):
    skill = lt.ProMP(weights=6).fit(shown(noise=0.02))
    motion = shown(1, seed=9, noise=0.02)[0].motion
    rows = np.kron(np.eye(3), skill.basis(motion.times / motion.duration))
    covariance = rows @ skill.weights.covariance @ rows.T
    covariance += np.kron(np.diag(skill.noise), np.eye(200))
    residual = motion.positions.T.ravel() - rows @ skill.weights.mean
    _, volume = np.linalg.slogdet(2 * np.pi * covariance)
    expected = -0.5 * (residual @ np.linalg.solve(covariance, residual) + volume)
    assert skill.log_likelihood(motion) == pytest.approx(expected, rel=1e-8)


def test_likelihood_tells_alike_from_strange_and_ignores_duration(shown):
    skill = lt.ProMP().fit(shown(noise=0.01))
    alike = shown(1, seed=5, noise=0.01)[0].motion
    slow = shown(1, seed=5, noise=0.01, duration=6.0)[0].motion
    strange = lt.JointTrajectory(alike.times, alike.positions[::-1])
    assert skill.log_likelihood(alike) > skill.log_likelihood(strange)
    assert skill.log_likelihood(slow) == pytest.approx(skill.log_likelihood(alike))


def test_duration_scales_velocities(skill):
    slow = skill.lasting(4.0)
    np.testing.assert_allclose(slow.distribution(2 * TIMES)[0], skill.distribution(TIMES)[0])
    np.testing.assert_allclose(
        slow.distribution(2 * TIMES, order=1)[0],
        0.5 * skill.distribution(TIMES, order=1)[0],
        atol=1e-12,
    )


def test_rhythmic_motion_closes_and_repeats():
    u = np.linspace(0.0, 1.0, 150)
    circle = [
        lt.Demonstration(
            lt.Trajectory(
                3 * u, r * np.column_stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)])
            )
        )
        for r in (0.9, 1.0, 1.1)
    ]
    skill = lt.ProMP(basis="rhythmic", weights=12).fit(circle)
    times = np.linspace(0.0, 3.0, 50)
    for order in (0, 1, 2):
        first, _ = skill.distribution(times, order=order)
        np.testing.assert_allclose(
            skill.distribution(times + 6.0, order=order)[0], first, atol=1e-8
        )
    np.testing.assert_allclose(np.linalg.norm(skill.distribution(times)[0], axis=1), 1.0, atol=1e-3)
    assert "goal" not in skill.supports
    with pytest.raises(UnsupportedQuery, match="goal"):
        skill.generate(goal=(1.0, 0.0))


def test_skill_with_limits_and_joints_is_saved(skill, tmp_path):
    limited = skill.within([-9.0] * 3, [1.0, np.inf, 9.0])
    limited.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert loaded.coordinates.joint_names == ("a", "b", "c")
    assert loaded.generate().positions.tobytes() == limited.generate().positions.tobytes()
    for a, b in zip(loaded.bounds, limited.bounds, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda s: s.distribution([0.1, 2.5]), "times: .* got 2.5 s"),
        (lambda s: s.distribution([0.0], order=3), "order"),
        (lambda s: s.condition(1.0, [1.0]), "position"),
        (lambda s: s.condition(np.nan, [0.0] * 3), "time"),
        (lambda s: s.condition(1.0, [0.0] * 3, covariance=-np.eye(3)), "covariance"),
        (lambda s: s.condition(1.0, [0.0], columns=[3]), "columns"),
        (lambda s: s.condition(1.0, [0.0, 0.0], columns=[1, 1]), "columns"),
        (lambda s: s.sample(0, seed=0), "count"),
        (lambda s: s.lasting(0.0), "duration"),
        (lambda s: s.within([0.0] * 3, [0.0] * 3), "lower"),
        (lambda s: s.log_likelihood(lt.Trajectory([0, 1], [[0, 0], [1, 1]])), "trajectory"),
        (lambda s: s.log_likelihood(3), "trajectory: .* got int"),
        (lambda s: s.log_likelihood(lt.Trajectory([0], [[0]])), "trajectory: .* got one sample"),
        (lambda s: s.generate(obstacles=[lt.Sphere(0.1, (0, 0, 0))]), "obstacles"),
    ],
)
def test_bad_arguments_are_refused_by_name(skill, call, name):
    with pytest.raises(InvalidInput, match=name):
        call(skill)
