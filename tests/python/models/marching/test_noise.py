"""What noise in the recordings changes in Fast Marching Learning: nearly nothing."""

import numpy as np
import pytest
from models.marching.paths import gaps_to
from motions import minimum_jerk

import leadthrough as lt
from leadthrough.preprocess.resample import arc_length

SHARE = np.linspace(0.0, 1.0, 200)
RISE = minimum_jerk(SHARE)
BOW = np.column_stack([RISE, 0.2 * np.sin(np.pi * RISE)])  # 1.09 m
NOISE = 0.03  # m


def shown(seed, noise=NOISE, *, pause=0):
    points = np.concatenate([BOW, np.repeat(BOW[-1:], pause, axis=0)])
    noisy = points + np.random.default_rng(seed).normal(0.0, noise, points.shape)
    return lt.Demonstration(lt.Trajectory(np.linspace(0.0, 2.0, len(points)), noisy))


@pytest.mark.parametrize("count", [1, 4])
def test_noise_changes_neither_duration_nor_radius(count):
    clean = lt.FastMarching().fit([shown(0, 0.0)])
    for seed in range(3):
        skill = lt.FastMarching().fit([shown(10 * seed + i) for i in range(count)])
        assert skill.generate().duration == pytest.approx(2.0, rel=0.03)
        assert skill.area_of_influence == pytest.approx(clean.area_of_influence, rel=0.12)


def test_motion_is_as_long_as_the_demonstration_without_its_noise():
    motion = lt.FastMarching().fit([shown(i) for i in range(4)]).generate()
    assert arc_length(motion.positions)[-1] == pytest.approx(1.09, rel=0.05)
    gaps = gaps_to(BOW, motion.positions)
    assert gaps.max() < 1.5 * NOISE


def test_noise_in_a_pause_is_no_progress():
    still = lt.FastMarching().fit([shown(0, 0.001, pause=200)]).generate()
    done = arc_length(still.positions)
    assert done[len(done) // 2] > 0.95 * done[-1]
