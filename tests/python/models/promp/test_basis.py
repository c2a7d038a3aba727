"""Basis functions over the phase."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.models.promp.model import from_archive

PHASES = np.linspace(0.0, 1.0, 301)


def in_the_peers_layout(count):
    """movement_primitives' functions: all centres inside, their overlap 0.7."""
    centres = np.linspace(0.0, 1.0, count)
    variance = -1.0 / (8.0 * count**2 * np.log(0.7))
    rows = np.exp(-((PHASES[:, None] - centres) ** 2) / (2.0 * variance))
    return rows / rows.sum(axis=1, keepdims=True)


def detailed(length):
    """Twenty motions of seven joints with detail of a length, varying about a common one."""
    rng = np.random.default_rng(0)
    gaps = (PHASES[:, None] - PHASES) / length
    root = np.linalg.cholesky(np.exp(-0.5 * gaps**2) + 1e-9 * np.eye(len(PHASES)))
    drawn = np.einsum("ij,mjk->mik", root, rng.normal(size=(20, len(PHASES), 7)))
    return (root @ rng.normal(size=(len(PHASES), 7))) + 0.2 * drawn


def distributed(curves, count):
    """Means and standard deviations: of a skill, and of least squares in the peer's layout."""
    skill = lt.ProMP(weights=count).fit([lt.JointTrajectory(PHASES, each) for each in curves])
    mean, covariance = skill.distribution(PHASES)
    rows = in_the_peers_layout(count)
    theirs = rows @ np.linalg.pinv(rows) @ curves
    # The peer's estimate is the most likely one, which divides by the number of motions.
    return (mean, np.sqrt(np.einsum("nii->ni", covariance))), (theirs.mean(0), theirs.std(0))


def rms(errors):
    return float(np.sqrt((errors**2).mean()))


@pytest.mark.parametrize("count", [6, 10, 14])
@pytest.mark.parametrize("length", [0.3, 0.15, 0.1])
def test_as_few_functions_resolve_as_much_as_the_peers(length, count):
    curves = detailed(length)
    (ours, _), (theirs, _) = distributed(curves, count)
    assert rms(ours - curves.mean(axis=0)) <= rms(theirs - curves.mean(axis=0))


@pytest.mark.parametrize("count", [6, 10, 14])
@pytest.mark.parametrize("length", [0.3, 0.15, 0.1, 0.07, 0.05])
def test_deviations_are_told_as_finely_as_by_the_peer(length, count):
    curves = detailed(length)
    (_, ours), (_, theirs) = distributed(curves, count)
    shown = curves.std(axis=0, ddof=1)
    assert rms(ours - shown) <= rms(theirs - shown)


@pytest.mark.parametrize(("length", "count"), [(0.07, 6), (0.07, 10), (0.05, 10), (0.05, 14)])
def test_detail_finer_than_the_functions_is_told_nearly_as_well_as_by_any_functions(length, count):
    """The least error of any `count` functions is that of the motions' principal components."""
    curves = detailed(length)
    (ours, _), _ = distributed(curves, count)
    gaps = (PHASES[:, None] - PHASES) / length
    beyond = np.linalg.eigvalsh(np.exp(-0.5 * gaps**2))[:-count]
    least = np.sqrt(beyond.clip(0.0).sum() / len(PHASES))
    assert least > 0.18  # of detail whose height is 1
    assert rms(ours - curves.mean(axis=0)) <= 1.16 * least


def test_files_without_a_margin_have_the_one_of_their_time():
    shown = [lt.Trajectory(PHASES, np.column_stack([PHASES, PHASES**2]))]
    skill = lt.ProMP(weights=8, margin=1.0).fit(shown)
    settings, arrays = skill.to_archive()
    settings["model"].pop("margin")
    again = from_archive(settings, arrays)
    np.testing.assert_array_equal(again.generate().positions, skill.generate().positions)
    assert lt.ProMP(weights=8).fit(shown).basis.centres[0] == pytest.approx(-0.25 / 6.5)
