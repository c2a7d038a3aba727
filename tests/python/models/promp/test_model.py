"""ProMPs fitted to demonstrations."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import FitError, InvalidInput

TIMES = np.linspace(0.0, 2.0, 200)


def test_mean_and_spread_are_those_of_the_demonstrations(shown):
    demonstrations = shown(40)
    mean, covariance = lt.ProMP().fit(demonstrations).distribution(TIMES)
    curves = np.stack([each.motion.positions for each in demonstrations])
    np.testing.assert_allclose(mean, curves.mean(axis=0), atol=1e-3)
    deviation = np.sqrt(np.einsum("nii->ni", covariance))
    np.testing.assert_allclose(deviation, curves.std(axis=0, ddof=1), atol=0.05)


@pytest.mark.parametrize("estimator", ["least_squares", "em"])
def test_tiny_and_singular_sets_give_usable_models(estimator, shown):
    demonstrations = shown(1)
    still = np.array(demonstrations[0].motion.positions)
    still[:, 1] = 0.4
    constant = [lt.Demonstration(lt.JointTrajectory(TIMES, still + 0.01 * i)) for i in range(2)]
    for several in (demonstrations, 3 * demonstrations, constant):
        skill = lt.ProMP(estimator=estimator).fit(several)
        via = skill.distribution([1.0])[0][0] + 0.05
        motion = skill.condition(1.0, via).generate(start=(0.1, 0.4, 0.1))
        np.testing.assert_allclose(motion.positions[0], (0.1, 0.4, 0.1), atol=1e-6)
        np.testing.assert_allclose(motion.positions[100], via, atol=1e-6)
        assert np.isfinite(skill.log_likelihood(several[0].motion))
        assert len(skill.sample(2, seed=0)) == 2


def test_few_samples_are_enough():
    u = np.linspace(0.0, 1.0, 4)
    few = [lt.Demonstration(lt.Trajectory(u, np.column_stack([u, a * u]))) for a in (0.9, 1.1)]
    mean, _ = lt.ProMP().fit(few).distribution(np.linspace(0, 1, 30))
    np.testing.assert_allclose(mean[:, 1], mean[:, 0], atol=0.02)


def test_parts_are_refused_with_the_way_out(shown):
    demonstrations = shown(2)
    with pytest.raises(FitError, match="em"):
        lt.ProMP().fit(demonstrations, phases=[np.linspace(0, 1, 200), np.linspace(0.5, 1, 200)])


@pytest.mark.parametrize("ends", [(-0.1, 1.0), (0.0, 1.1)])
def test_phases_beyond_the_motion_are_refused(shown, ends):
    with pytest.raises(InvalidInput, match=r"phases\[1\]: expected phases in \[0, 1\]"):
        lt.ProMP().fit(shown(2), phases=[np.linspace(0, 1, 200), np.linspace(*ends, 200)])


@pytest.mark.parametrize(
    "options", [{"weights": 3}, {"basis": "sines"}, {"estimator": "x"}, {"regularization": 0.0}]
)
def test_bad_options_are_refused_by_name(options):
    with pytest.raises(InvalidInput, match=next(iter(options))):
        lt.ProMP(**options)
