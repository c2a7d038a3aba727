"""Motions recognised from their beginning."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models import infer


def test_beginning_of_a_motion_tells_which_how_fast_and_how_it_goes_on(skills, family):
    whole = family(-0.12, count=1, seed=9, duration=2.6)[0].motion
    seen = lt.Trajectory(whole.times[:60], whole.positions[:60])
    found = infer(seen, skills)
    assert found.best == 1
    assert found.probabilities[1] > 0.99
    assert found.durations[1] == pytest.approx(2.6, rel=0.1)
    assert found.phases[1] == pytest.approx(60 / 150, rel=0.1)
    ahead, _ = found.skills[1].distribution(np.minimum(whole.times, found.durations[1]))
    assert np.abs(ahead - whole.positions).max() < 0.04
    before, _ = skills[1].distribution(np.minimum(whole.times, 2.0))
    assert np.abs(ahead - whole.positions).max() < np.abs(before - whole.positions).max()


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_probabilities_are_about_those_of_the_families_that_motions_are_drawn_from(noise, family):
    """Two families that overlap: by Bayes' rule on a motion's height, nothing else tells them."""
    heights, spread = (0.10, 0.13), 0.02

    def noisy(height, seed, count):
        rng = np.random.default_rng(seed)
        return [
            lt.Demonstration(
                lt.Trajectory(
                    each.motion.times,
                    each.motion.positions + noise * rng.standard_normal((150, 2)),
                )
            )
            for each in family(height, seed=seed, count=count, spread=spread)
        ]

    model = lt.ProMP(weights=10)
    skills = [model.fit(noisy(h, s, 40)) for h, s in zip(heights, (1, 2), strict=True)]
    losses, gaps = [], []
    for own, height in enumerate(heights):
        for each in noisy(height, 50 + own, 12):
            seen = lt.Trajectory(each.motion.times[:75], each.motion.positions[:75])
            found = infer(seen, skills).probabilities
            peak = each.motion.positions[:, 1].max()
            likely = np.exp(-((peak - np.array(heights)) ** 2) / (2 * spread**2))
            gaps.append(found[0] - likely[0] / likely.sum())
            losses.append((np.log(found[own]), np.log(likely[own] / likely.sum())))
    ours, exact = -np.mean(losses, axis=0)
    assert ours < exact + 0.3
    assert np.sqrt(np.mean(np.square(gaps))) < 0.3


def test_prior_counts(skills, family):
    whole = family(0.1, count=1, seed=9)[0].motion
    seen = lt.Trajectory(whole.times[:3], whole.positions[:3])
    assert infer(seen, skills, prior=[0.0, 1.0]).best == 1
    with pytest.raises(InvalidInput, match="prior"):
        infer(seen, skills, prior=[0.0, 0.0])
    with pytest.raises(InvalidInput, match="observed"):
        infer(lt.Trajectory([0.0], [[0.0, 0.0]]), skills)


def test_skills_of_other_joints_are_refused(skill, shown):
    renamed = [
        lt.Demonstration(lt.JointTrajectory(each.motion.times, each.motion.positions))
        for each in shown()
    ]
    with pytest.raises(InvalidInput, match="same joints"):
        infer(shown(1)[0].motion, [skill, lt.ProMP().fit(renamed)])


@pytest.mark.parametrize("samples", [2, 40])
def test_the_log_likelihood_is_the_density_of_the_samples(samples, skills, family):
    skill, motion = skills[0], family(0.11, count=1, seed=4)[0].motion
    rows = np.linspace(0, 149, samples).astype(int)
    seen = lt.Trajectory(motion.times[rows], motion.positions[rows])
    phases = (seen.times - seen.times[0]) / (seen.times[-1] - seen.times[0])
    every = np.kron(np.eye(2), skill.basis(phases))
    root = skill.weights.steady_root
    noise = np.diag(np.repeat(skill.noise, samples))
    spread = multivariate_normal(
        every @ skill.weights.mean, every @ root @ root.T @ every.T + noise
    )
    density = spread.logpdf(seen.positions.T.ravel())
    assert skill.log_likelihood(seen) == pytest.approx(density, rel=1e-6)
