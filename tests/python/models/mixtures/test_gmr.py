"""GMR: motions and updates."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import FitError

U = np.linspace(0.0, 1.0, 160)


def test_regression_follows_mean_and_spread_of_the_demonstrations(family):
    shown = family(20)
    skill = lt.GMR(8).fit(shown)
    mean, covariance = skill.regress(2.0 * U)
    curves = np.stack([each.motion.positions for each in shown])
    assert np.abs(mean - curves.mean(axis=0)).max() < 0.03
    spread = np.sqrt(covariance[:, 1, 1])
    assert spread[80] == pytest.approx(curves[:, 80, 1].std(), rel=0.3)
    assert spread[5] < 0.5 * spread[80]


def test_mixture_has_the_time_first_in_seconds(family):
    mixture = lt.GMR(5).fit(family()).mixture
    assert mixture.means.shape == (5, 3)
    assert mixture.covariances.shape == (5, 3, 3)
    assert 1.5 < mixture.means[:, 0].max() < 2.0
    np.testing.assert_allclose(mixture.means[:, 1], mixture.means[:, 0] / 2.0, atol=0.02)


def test_mixture_may_be_asked_for_the_time_of_a_place(family):
    mixture = lt.GMR(8).fit(family()).mixture
    mean, _ = mixture.regress([[0.25], [0.5]], inputs=[1], outputs=[0])
    np.testing.assert_allclose(mean[:, 0], [0.5, 1.0], atol=0.05)


def test_number_of_components_may_be_chosen_by_the_data(family):
    skill = lt.GMR(components=None).fit(family(2))
    assert 3 <= skill.mixture.count <= 15


def test_update_comes_near_to_a_fit_of_everything(family):
    old, new = family(6, seed=1), family(6, seed=2, height=0.6)
    # One start each: the best of several may be another maximum, which no update leads to.
    model = lt.GMR(6, starts=1)
    both = model.fit(old + new)
    updated = model.fit(old).updated(new)
    assert updated.demonstration_count == 12
    mean, _ = updated.regress(2.0 * U)
    assert np.abs(mean - both.regress(2.0 * U)[0]).max() < 0.05
    before = np.abs(model.fit(old).regress(2.0 * U)[0] - both.regress(2.0 * U)[0]).max()
    assert np.abs(mean - both.regress(2.0 * U)[0]).max() < 0.6 * before


def test_update_with_the_same_changes_nothing(family):
    shown = family(8)
    skill = lt.GMR(5).fit(shown)
    again = skill.updated(shown)
    np.testing.assert_allclose(again.regress(2 * U)[0], skill.regress(2 * U)[0], atol=0.01)


def test_joints_come_back_with_their_names():
    shown = [
        lt.Demonstration(lt.JointTrajectory(U, np.column_stack([U, a * U]), joint_names=("a", "b")))
        for a in (0.9, 1.1)
    ]
    motion = lt.GMR(3).fit(shown).generate()
    assert isinstance(motion, lt.JointTrajectory)
    assert motion.joint_names == ("a", "b")


def test_tiny_and_singular_sets_give_usable_models(family):
    one = family(1)
    constant = lt.Demonstration(lt.Trajectory(U, np.column_stack([U, np.full(160, 0.3)])))
    for given in (one, 3 * one, [constant]):
        motion = lt.GMR().fit(given).generate(start=(0.1, 0.1))
        assert np.isfinite(motion.positions).all()
        np.testing.assert_allclose(motion.positions[0], (0.1, 0.1), atol=1e-12)
    with pytest.raises(FitError, match="none"):
        lt.GMR().fit([])


def test_the_order_of_the_demonstrations_does_not_matter(family):
    shown = family(5)
    one, other = (lt.GMR(6).fit(each).mixture for each in (shown, shown[::-1]))
    np.testing.assert_allclose(one.means, other.means, atol=1e-9)
