import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.preprocess import sample_evenly, smooth_by_spline, smooth_motion

TIMES = 3.0 + np.linspace(0.0, 1.2, 61) ** 1.3
ARC = np.column_stack([np.sin(TIMES), TIMES**2])


def shown(motion):
    return lt.Demonstration(motion, "arc")


def test_even_samples_never_leave_the_range_of_their_neighbours():
    steps = shown(lt.Trajectory([0, 1, 1.1, 2], [[0], [0], [1], [1]]))
    even = sample_evenly(steps, rate=100).motion
    assert np.array_equal(even.times[:3], [0, 0.01, 0.02])
    assert even.positions.min() == 0.0
    assert even.positions.max() == 1.0
    assert not even.positions[even.times <= 1.0].any()


def test_velocities_events_and_names_are_kept():
    motion = lt.JointTrajectory(TIMES, ARC, ARC, None, ("a", "b"), (lt.Event(3.2, "grasp"),))
    even = sample_evenly(shown(motion), rate=50)
    assert even.name == "arc"
    assert even.motion.joint_names == ("a", "b")
    assert even.events == motion.events
    assert even.motion.velocities.shape == even.motion.positions.shape
    assert even.motion.accelerations is None


def test_a_cubic_passes_smoothing_unchanged():
    times = np.arange(50) / 25
    cubic = np.column_stack([times**3 - times, 2.0 - times**2])
    smooth = smooth_motion(shown(lt.JointTrajectory(times, cubic)), window=0.4).motion
    np.testing.assert_allclose(smooth.positions, cubic, atol=1e-12)
    np.testing.assert_allclose(smooth.velocities[:, 0], 3 * times**2 - 1, atol=1e-10)
    np.testing.assert_allclose(smooth.accelerations[:, 1], -2.0, atol=1e-8)


def test_uneven_samples_have_to_be_made_even_first():
    demonstration = shown(lt.Trajectory(TIMES, ARC))
    with pytest.raises(InvalidInput, match=r"evenly spaced times; .* preprocess.sample_evenly"):
        smooth_motion(demonstration, window=0.2)
    even = sample_evenly(demonstration, rate=100)
    assert smooth_motion(even, window=0.2).motion.positions.shape == even.motion.positions.shape


def test_a_spline_takes_noise_from_uneven_samples():
    rng = np.random.default_rng(1)
    noisy = lt.JointTrajectory(TIMES, ARC + 5e-3 * rng.standard_normal(ARC.shape))
    smooth = smooth_by_spline(shown(noisy)).motion
    assert np.abs(smooth.positions - ARC).std() < 0.5 * np.abs(noisy.positions - ARC).std()
    assert np.abs(smooth.velocities[10:-10, 0] - np.cos(TIMES[10:-10])).max() < 0.1
    straight = smooth_by_spline(shown(noisy), stiffness=1e9).motion
    np.testing.assert_allclose(straight.accelerations, 0.0, atol=1e-3)


def test_smoothed_orientations_stay_rotations():
    rng = np.random.default_rng(2)
    times = np.arange(100) / 50
    turned = lt.rotations.exp(np.column_stack([3 * times, 0 * times, 0 * times]))
    trembling = lt.rotations.compose(turned, lt.rotations.exp(0.01 * rng.standard_normal((100, 3))))
    poses = shown(lt.PoseTrajectory(times, np.zeros((100, 3)), trembling))
    for smooth in (smooth_motion(poses, window=0.3), smooth_by_spline(poses)):
        angles = lt.rotations.distance(smooth.motion.orientations, turned)
        assert angles[5:-5].max() < 0.015
        assert angles.mean() < 0.5 * lt.rotations.distance(trembling, turned).mean()


def test_too_little_or_nothing_is_refused():
    for function, options in (
        (sample_evenly, {"rate": 10}),
        (smooth_motion, {"window": 1}),
        (smooth_by_spline, {}),
    ):
        refused("demonstration: expected a Demonstration", function, ARC, **options)
        refused("at least two samples", function, shown(lt.Trajectory([0], [[1]])), **options)
    refused("at least 5 samples", smooth_by_spline, shown(lt.Trajectory([0, 1], [[1], [2]])))
    refused("stiffness: ", smooth_by_spline, shown(lt.Trajectory(TIMES, ARC)), stiffness=-1)
