"""Basis functions over the phase."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.models.promp.basis import KINDS, Basis, lines, raised
from leadthrough.models.promp.model import from_archive

PHASES = np.linspace(0.0, 1.0, 301)


@pytest.fixture(params=KINDS)
def basis(request):
    return Basis(request.param, 12)


def test_functions_sum_to_one(basis):
    np.testing.assert_allclose(basis(PHASES).sum(axis=1), 1.0, atol=1e-12)
    assert (basis(PHASES) >= 0.0).all()


@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_are_those_of_central_differences(basis, order):
    step = 1e-5
    inside = PHASES[1:-1]
    ahead, behind = (basis(inside + s, order - 1) for s in (step, -step))
    difference = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(basis(inside, order), difference, atol=2e-3 * 12**order)


def test_rhythmic_functions_repeat_with_every_period():
    rhythmic = Basis("rhythmic", 9)
    for order in (0, 1, 2):
        np.testing.assert_allclose(rhythmic(PHASES, order), rhythmic(PHASES + 3, order), atol=1e-8)


def test_each_function_is_largest_near_its_centre(basis):
    inside = (basis.centres >= 0.0) & (basis.centres <= 1.0)
    largest = PHASES[basis(PHASES).argmax(axis=0)]
    gap = np.abs(largest - basis.centres)[inside]
    if basis.is_rhythmic:  # phases 0 and 1 are the same
        gap = np.minimum(gap, 1.0 - gap)
    assert gap.max() < 0.06


def test_straight_lines_are_not_rough():
    for kind in ("bspline", "gaussian"):
        line = np.linspace(-1.0, 2.0, 12)
        assert line @ Basis(kind, 12).roughness @ line == pytest.approx(0.0, abs=1e-12)


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


@pytest.mark.parametrize("end", [0, 1])
def test_a_motion_that_varies_at_one_end_only_is_raised_to_the_least_at_the_other(end):
    basis, least = Basis("gaussian", 12), 0.03
    ramp = lines(basis)[:, [end]]
    covariance = raised(ramp @ ramp.T, basis, least)
    spread = np.sqrt(np.einsum("nk,kl,nl->n", basis(PHASES), covariance, basis(PHASES)))
    assert spread.min() >= 0.95 * least
    np.testing.assert_allclose(spread[[0, -1]], [1.0, least][:: 1 - 2 * end], rtol=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_curves_are_products_with_the_weights_on_any_number_of_threads(kind):
    basis, phases = Basis(kind, 9), np.linspace(0.0, 1.0, 301)
    weights, paces = np.random.default_rng(0).normal(size=(5, 2 * 9)), np.array([1.0, 0.5, 0.25])
    blocks, certain = basis.curves(phases, weights, paces, most=3, threads=1)
    assert certain
    assert [len(each) for each in blocks] == [3, 2]
    threaded, _ = basis.curves(phases, weights, paces, most=3, threads=3)
    for one, three in zip(blocks, threaded, strict=True):
        assert one.tobytes() == three.tobytes()
    rows = np.stack([basis(phases, order) * pace for order, pace in enumerate(paces)])
    wanted = np.einsum("onk,mdk->mond", rows, weights.reshape(5, 2, 9))
    scale = np.abs(wanted).max(axis=(0, 2, 3), keepdims=True)
    np.testing.assert_allclose(np.concatenate(blocks) / scale, wanted / scale, atol=1e-14)
