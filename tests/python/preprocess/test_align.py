"""Demonstrations of different timing, aligned in time."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.preprocess import align_by_arc_length, align_by_time_warping
from leadthrough_studies.robotasks import study as robotasks

ALIGN = [align_by_time_warping, align_by_arc_length]


def paused(at, *, seed=0, noise=0.0):
    """A curve whose hand rests for a third of the time at a fraction of its length."""
    t = np.linspace(0.0, 3.0, 900)
    u = np.interp(t, [0.0, 2.0 * at, 2.0 * at + 1.0, 3.0], [0.0, at, at, 1.0])
    points = np.column_stack([u, np.sin(6 * u)])
    points += noise * np.random.default_rng(seed).standard_normal(points.shape)
    return lt.Demonstration(lt.Trajectory(t, points), name=f"pause at {at}")


def spread(demonstrations):
    """Root mean square distance from the mean curve at equal fractions of the duration."""
    curves = [at(each.motion, np.linspace(0.0, 1.0, 400)) for each in demonstrations]
    return np.sqrt(np.var(curves, axis=0).sum(axis=1).mean())


def at(motion, u):
    """Positions at fractions of the duration."""
    own = motion.times / motion.duration
    return np.column_stack([np.interp(u, own, column) for column in motion.positions.T])


@pytest.mark.parametrize("align", ALIGN)
def test_pauses_at_different_places_no_longer_matter(align):
    shown = [paused(at, seed=i, noise=5e-4) for i, at in enumerate((0.2, 0.5, 0.8))]
    aligned = align(shown)
    assert spread(aligned) < 0.15 * spread(shown)
    assert [each.name for each in aligned] == [each.name for each in shown]
    for each, given in zip(aligned, shown, strict=True):
        assert each.motion.times.tobytes() == aligned[0].motion.times.tobytes()
        np.testing.assert_array_equal(
            each.motion.positions[[0, -1]], given.motion.positions[[0, -1]]
        )


@pytest.mark.parametrize("align", ALIGN)
def test_recorded_hands_that_pause_are_aligned(align, recordings):
    shown = lt.read_demonstrations(recordings / "panda_symbol" / "symbol17.mat", rate=1000)
    assert spread(align(shown)) < 0.3 * spread(shown)


def test_the_reference_keeps_its_timing():
    shown = [paused(0.3), paused(0.7)]
    aligned = align_by_time_warping(shown, reference=1)
    resampled = at(shown[1].motion, aligned[1].motion.times / shown[1].motion.duration)
    np.testing.assert_allclose(aligned[1].motion.positions, resampled, atol=0.01)


def test_arc_length_makes_the_speed_constant():
    (aligned,) = align_by_arc_length([paused(0.4)])
    speed = np.linalg.norm(np.diff(aligned.motion.positions, axis=0), axis=1)
    assert speed.std() < 0.1 * speed.mean()
    assert aligned.motion.duration == pytest.approx(3.0)


@pytest.mark.parametrize("align", ALIGN)
def test_poses_and_joints_go_along(align):
    t = paused(0.5).motion.times
    points = paused(0.5).motion.positions
    turned = rotations.exp(np.outer(points[:, 0], [0.0, 0.0, 2.0]))
    pose = lt.Demonstration(
        lt.PoseTrajectory(t, np.column_stack([points, 0 * t]), turned), name="pose"
    )
    joints = lt.Demonstration(lt.JointTrajectory(t, points, joint_names=("a", "b")))
    (aligned,) = align([pose])
    expected = rotations.exp(np.outer(aligned.motion.positions[:, 0], [0.0, 0.0, 2.0]))
    assert rotations.distance(aligned.motion.orientations, expected).max() < 0.02
    assert align([joints])[0].motion.joint_names == ("a", "b")


@pytest.mark.parametrize("align", ALIGN)
def test_bad_demonstrations_are_refused_by_name(align):
    single = lt.Demonstration(lt.Trajectory([0.0], [[0.0, 0.0]]))
    joints = lt.Demonstration(lt.JointTrajectory([0.0, 1.0], [[0.0, 0.0], [1.0, 1.0]]))
    for given in ([], paused(0.5), [single], [None], [paused(0.5), joints]):
        refused("demonstrations", align, given)


def test_still_demonstration_has_no_arc_length():
    still = lt.Demonstration(lt.Trajectory([0.0, 1.0], [[1.0, 1.0], [1.0, 1.0]]))
    refused("move", align_by_arc_length, [still])


def turning(at, *, shift=0.0):
    """A tool that turns on the spot, at a fraction of the time."""
    t = np.linspace(0.0, 2.0, 400)
    turned = 1.0 / (1.0 + np.exp(-40.0 * (t / 2.0 - at)))
    points = np.full((400, 3), shift)
    return lt.PoseTrajectory(t, points, rotations.exp(np.outer(turned, [0.0, 1.0, 1.0])))


def test_orientations_are_brought_into_step_too():
    shown = [turning(at, shift=0.0001 * i) for i, at in enumerate((0.3, 0.5, 0.7))]
    aligned = [each.motion for each in align_by_time_warping(shown)]
    before = rotations.distance(shown[0].orientations, shown[2].orientations).max()
    after = rotations.distance(aligned[0].orientations, aligned[2].orientations).max()
    assert before > 1.2
    assert after < 0.15


def test_all_take_the_mean_timing_whatever_their_order():
    shown = [paused(at) for at in (0.1, 0.2, 0.8)]
    shown.append(
        lt.Demonstration(lt.Trajectory(0.5 * shown[0].motion.times, shown[0].motion.positions))
    )
    one = align_by_time_warping(shown)
    assert one[0].motion.duration == pytest.approx((3 * 3.0 + 1.5) / 4)
    # Aligned demonstrations pass every phase at the mean of its recorded times.
    times = []
    for each in shown:
        fractions = each.motion.times / each.motion.duration
        times.append(np.interp([0.05, 0.3, 0.6, 0.95], each.motion.positions[:, 0], fractions))
    for each in one:
        u = each.motion.times / each.motion.duration
        own = np.interp([0.05, 0.3, 0.6, 0.95], each.motion.positions[:, 0], u)
        np.testing.assert_allclose(own, np.mean(times, axis=0), atol=0.03)
    other = align_by_time_warping(shown[::-1])[::-1]
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a.motion.positions, b.motion.positions, atol=1e-6)


@pytest.mark.parametrize("task", ["bottle2shelf", "pouring"])
def test_aligning_real_poses_makes_no_left_out_prediction_worse(recordings, task):
    """One demonstration's clock raised the mean error from 27 to 46 mm, small warps by up to 3 %.

    No timing of the other eight predicts better than their own: whatever model learns from them
    learns the same.
    """
    shown = robotasks.read(str(recordings / "robotasks" / f"{task}.npy"))
    for i in range(len(shown)):
        others = shown[:i] + shown[i + 1 :]
        for each, given in zip(align_by_time_warping(others), others, strict=True):
            np.testing.assert_array_equal(each.motion.times, given.motion.times)
            np.testing.assert_array_equal(each.motion.positions, given.motion.positions)
            np.testing.assert_array_equal(each.motion.orientations, given.motion.orientations)


def test_small_differences_in_timing_go_where_left_out_motions_are_then_predicted_better():
    shown = lt.io.lasa.load("Worm")
    aligned = align_by_time_warping(shown)
    assert 0.7 * spread(shown) < spread(aligned) < 0.9 * spread(shown)
    mean = np.mean([each.motion.duration for each in shown])
    assert aligned[0].motion.duration == pytest.approx(mean)


def test_demonstrations_in_step_keep_their_timing():
    shown = lt.io.lasa.load("Angle")
    u = np.linspace(0.0, 1.0, 50)
    for each, given in zip(align_by_time_warping(shown), shown, strict=True):
        np.testing.assert_allclose(at(each.motion, u), at(given.motion, u), atol=0.05)  # mm
