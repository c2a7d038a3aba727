"""Random paths and seeds of the studies: paths kept, parts that add up, and intervals."""

import numpy as np
import pytest
from scipy.stats import binom

from leadthrough.arm import Arm
from leadthrough_studies import intervals
from leadthrough_studies.human import repeated
from leadthrough_studies.human.demonstrations import FACTORS, START, human
from leadthrough_studies.human.polynomial import polynomial_mean
from leadthrough_studies.singularity import draws, joint_limits


def test_the_interval_of_a_median_covers_it():
    rng = np.random.default_rng(0)
    found = [intervals.median(rng.exponential(size=20)) for _ in range(2000)]
    assert np.mean([each["low"] <= np.log(2.0) <= each["high"] for each in found]) >= 0.95
    # Narrower by one rank at each end, it would not.
    assert 1.0 - 2.0 * binom.cdf(5, 20, 0.5) > 0.95 > 1.0 - 2.0 * binom.cdf(6, 20, 0.5)


def test_the_interval_of_a_correlation_holds_it():
    rng = np.random.default_rng(1)
    x = rng.normal(size=200)
    found = intervals.correlation(x, x + rng.normal(size=200))
    assert found["low"] < found["spearman"] < found["high"]
    assert found["spearman"] == pytest.approx(6.0 / np.pi * np.arcsin(np.sqrt(0.125)), abs=0.1)
    assert intervals.correlation(x, -(x**3))["spearman"] == pytest.approx(-1.0)


def test_kept_paths_have_the_papers_row_without_the_method():
    rows = draws.rows_of_tables(seed=3, unit=1.0, tip="panda_hand", paths=20)
    kept = [row for row in rows if row["study"] == "draws"]
    assert kept
    for row in kept:
        wanted, _ = draws.TABLES[row["table"]]
        assert np.abs(np.subtract(row["plain"], wanted)).max() <= draws.TOLERANCE
        assert np.shape(row["found"]) == (len(draws.GRID), 2)
    line = draws.table(rows)[0]
    assert line["kept"] == len([row for row in kept if row["table"] == "I"])
    assert line["below_10_low"] <= line["below_10_median"] <= line["below_10_high"]


def test_without_a_clamp_joints_leave_their_limits_and_with_it_none_does():
    table = {row["case"]: row for row in joint_limits.table(joint_limits.ends(seed=1, poses=40))}
    assert table["poses, task, clamp"]["inside_percent"] == 100.0
    assert table["inverse_kinematics_batch"]["reached_percent"] == 100.0
    assert table["poses, task"]["inside_high"] < 60.0
    assert table["positions, task"]["inside_percent"] > table["poses, task"]["inside_percent"]


def test_parts_of_the_loss_add_up():
    rows = [
        row
        for seed in (0, 1)
        for row in repeated.losses(seed=seed, count=3, joints=[1, 3], weights=20)
    ]
    parts = {row["part"]: row["mean"] for row in repeated.parts(rows)}
    assert sum(parts[each] for each in FACTORS) == pytest.approx(parts["all"] - parts["none"])
    assert parts["none"] == pytest.approx(0.0, abs=0.01)
    assert all(parts[each] > 0.0 for each in FACTORS)


def test_a_person_without_any_factor_moves_straight():
    (shown,) = human(1, np.random.default_rng(0), factors=())
    way = shown.motion.positions - START
    unit = way[-1] / np.linalg.norm(way[-1])
    assert np.abs(way - np.outer(way @ unit, unit)).max() < 1e-9
    mean = polynomial_mean([shown], weights=12)
    speed = mean.distribution(shown.motion.times, order=1)[0]
    truth = np.gradient(shown.motion.positions, shown.motion.times, axis=0)
    np.testing.assert_allclose(speed[5:-5], truth[5:-5], atol=2e-3)


def test_a_relation_counts_every_path_that_is_followed():
    rows = draws.relation(seed=0, paths=10)
    assert 0 < len(rows) <= 10
    arm = Arm.load("panda")
    assert min(row["condition"] for row in rows) > 1.0
    assert max(row["peak_velocity"] for row in rows) > 0.01 * arm.limits.velocity.max()
