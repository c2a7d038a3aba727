"""Several ProMPs at once, and one after the other."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.models import blend, combine

U = np.linspace(0.0, 1.0, 150)


def test_combination_of_a_skill_with_itself_keeps_the_mean_and_halves_the_covariance(skills):
    both = combine([skills[0], skills[0]])
    mean, covariance = skills[0].distribution(2 * U)
    np.testing.assert_allclose(both.distribution(2 * U)[0], mean, atol=1e-9)
    np.testing.assert_allclose(both.distribution(2 * U)[1], 0.5 * covariance, atol=1e-9)


def test_combination_meets_the_via_points_of_all(skills):
    first = skills[0].condition(0.5, (0.08, 0.06))
    second = skills[0].condition(1.5, (0.22, 0.08))
    mean, _ = combine([first, second]).distribution([0.5, 1.5])
    np.testing.assert_allclose(mean, [(0.08, 0.06), (0.22, 0.08)], atol=1e-4)


def test_surer_skill_has_more_weight(skills):
    sure = combine(skills, activations=[10.0, 0.1])
    gap = sure.distribution([1.0])[0] - skills[0].distribution([1.0])[0]
    assert np.abs(gap).max() < 0.01


def test_blend_goes_over_from_one_to_the_other(skills):
    share = np.clip(3.0 * U - 1.0, 0.0, 1.0)
    mean, covariance = blend(skills, 2 * U, np.column_stack([1 - share, share]))
    np.testing.assert_allclose(mean[:50], skills[0].distribution(2 * U[:50])[0], atol=1e-6)
    np.testing.assert_allclose(mean[-50:], skills[1].distribution(2 * U[-50:])[0], atol=1e-6)
    assert np.abs(np.diff(mean, axis=0)).max() < 0.01
    assert np.linalg.eigvalsh(covariance).min() > -1e-15


def posed(lean, *, count=8, seed=0):
    """Poses that turn by 4 rad about an axis that leans and varies a little."""
    rng = np.random.default_rng(seed)
    shown = []
    for _ in range(count):
        axis = np.array([lean, 0.2, 1.0]) + 0.08 * rng.standard_normal(3)
        turned = rotations.exp(np.outer(4.0 * U, axis / np.linalg.norm(axis)))
        points = np.column_stack([U, np.sin(U), 0.1 * rng.standard_normal() * U])
        shown.append(lt.PoseTrajectory(2.0 * U, points, turned))
    return shown


@pytest.fixture(scope="module")
def turning():
    model = lt.ProMP(weights=10)
    return [model.fit(posed(lean, seed=seed)) for lean, seed in ((0.1, 0), (0.3, 1))]


def test_poses_about_another_reference_are_distributed_as_before(turning):
    """Blended alone, the second skill is seen about the first one's reference."""
    times = np.array([0.4, 1.0, 1.6])
    mean, covariance = blend(turning, [0.0, *times, 2.0], np.tile([0.0, 1.0], (5, 1)))
    coordinates = turning[0].coordinates
    phases, other = times / 2.0, turning[1]
    weights = other.sample_weights(4000, seed=0).reshape(4000, 6, -1)
    columns = np.einsum("nk,mdk->mnd", other.basis(phases), weights)
    at = np.tile(phases, 4000)
    turned = other.coordinates.orientations(columns[..., 3:].reshape(-1, 3), at)
    seen = np.concatenate(
        [columns[..., :3], coordinates.tangent(turned, at).reshape(4000, 3, 3)], axis=2
    )
    np.testing.assert_allclose(seen.mean(axis=0), mean[1:4], atol=0.01)
    for i in range(3):
        wanted = covariance[1 + i]
        np.testing.assert_allclose(np.cov(seen[:, i].T), wanted, atol=0.06 * np.abs(wanted).max())


def test_poses_are_combined_between_the_two(turning):
    both = combine(turning)
    times = np.linspace(0.0, 2.0, 20)
    a, b, middle = (s.generate(dt=0.1).orientations for s in (*turning, both))
    apart = rotations.distance(a, b)
    assert (rotations.distance(a, middle) <= apart + 0.02).all()
    assert (rotations.distance(b, middle) <= apart + 0.02).all()
    same = combine([turning[0], turning[0]]).distribution(times)
    np.testing.assert_allclose(same[0], turning[0].distribution(times)[0], atol=1e-8)
    np.testing.assert_allclose(same[1], 0.5 * turning[0].distribution(times)[1], atol=1e-8)


def test_strangers_are_refused(turning, skills, family):
    turn = rotations.exp(np.tile([2.5, 0.0, 0.0], (150, 1)))
    away = [
        replace(each, orientations=rotations.compose(turn, each.orientations))
        for each in posed(0.1)
    ]
    refused("near", combine, [turning[0], lt.ProMP(weights=10).fit(away)])
    refused("weights", combine, [skills[0], lt.ProMP(weights=12).fit(family(0.1))])
    joints = [lt.JointTrajectory(U, np.column_stack([U, U]))]
    refused("points", blend, [skills[0], lt.ProMP().fit(joints)], U, np.ones((150, 2)))
    with pytest.raises(InvalidInput, match=r"activations: .* at sample 7"):
        blend(skills, U, np.where(np.arange(150) == 7, 0.0, np.ones((2, 150))).T)
