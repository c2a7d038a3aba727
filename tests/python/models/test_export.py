"""Skills exported for C++; the tests of C++ compare their steps with those of Python."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import leadthrough as lt
from leadthrough.check import InvalidInput, UnsupportedQuery

TIMES = np.linspace(0.0, 2.0, 201)
RISE = lt.trajectories.minimum_jerk_time_scaling(TIMES / 2.0)
POINTS = lt.Trajectory(TIMES, np.column_stack([RISE, np.sin(3.0 * RISE)]))
POSES = lt.PoseTrajectory(
    TIMES, np.column_stack([RISE, RISE, RISE]), lt.rotations.exp(np.outer(RISE, [0.3, 0.2, 0.5]))
)


@pytest.mark.parametrize(
    ("model", "motion"),
    [
        (lt.DMP(form="hoffmann"), POINTS),
        (lt.DMP(orientation="lifted"), POSES),
        (lt.ProMP(weights=8, basis="bspline"), POINTS),
        (lt.ProMP(weights=8), POSES),
        (lt.GMR(components=2), POINTS),
    ],
    ids=["form", "orientation", "bspline", "promp of poses", "gmr"],
)
def test_what_cpp_does_not_run_is_refused_with_what_it_does(model, motion, tmp_path):
    skill = model.fit([motion])
    with pytest.raises(UnsupportedQuery, match=r"expected a DMP of the form 'blended'"):
        skill.export(tmp_path / "skill.npz")
    assert not list(tmp_path.iterdir())


def test_an_exported_file_is_no_saved_skill(tmp_path):
    lt.DMP(weights=8).fit([POINTS]).export(tmp_path / "skill.npz")
    with pytest.raises(InvalidInput, match=r"expected a saved skill.*it is an export, for C\+\+"):
        lt.load_skill(tmp_path / "skill.npz")


def test_corrections_are_not_lost_without_a_word(tmp_path):
    corrected = lt.DMP(weights=8).fit([POINTS]).corrected(0.5, [0.1, 0.1])
    with pytest.raises(UnsupportedQuery, match="got a CorrectedSkill of DMP"):
        corrected.export(tmp_path / "skill.npz")


def test_fast_marching_exports_its_policy(tmp_path):
    skill = lt.FastMarching().fit([POINTS])
    skill.export(tmp_path / "skill.npz")
    skill.policy_to().export(tmp_path / "policy.npz")
    with np.load(tmp_path / "skill.npz") as one, np.load(tmp_path / "policy.npz") as other:
        assert set(one) == set(other)
        assert all(np.array_equal(one[name], other[name]) for name in one)


def test_a_policy_has_the_mean_speed_of_the_eight_nearest_samples():
    policy = lt.FastMarching().fit([POINTS]).policy_to()
    rng = np.random.default_rng(0)
    points = POINTS.positions[rng.integers(0, 150, 100)] + rng.normal(0.0, 0.02, (100, 2))
    distances, nearest = cKDTree(policy.speeds.positions).query(points, 8)
    weights = 1.0 / (distances + policy.grid.spacing.max())
    speeds = (weights * policy.speeds.speeds[nearest]).sum(axis=1) / weights.sum(axis=1)
    left = np.linalg.norm(policy.goal - points, axis=1)
    slowed = np.minimum(speeds, policy.speeds.mean / policy.slowing * left)
    np.testing.assert_allclose(np.linalg.norm(policy(points), axis=1), slowed, rtol=1e-12)
