"""Movement primitives of poses; the hard rotations among them."""

import numpy as np
import pytest
from models.dmp.turns import (
    DURATION,
    HARD,
    HARD_AT_50_HZ,
    about_turning_axis,
    angle_turned,
    demonstration,
    errors_of,
    fitted,
    moved_goal,
    noisy,
    positions,
    turn,
)

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError
from leadthrough.preprocess import segment


@pytest.mark.parametrize("case", HARD.values(), ids=HARD)
def test_hard_rotations_are_replayed(case):
    error = errors_of(fitted(*case), *case)
    assert error.mean() <= 0.03
    assert error.max() <= 0.3


def test_light_noise_at_100_hz_is_averaged_out():
    u, q = turn(350, 100)
    error = errors_of(fitted(u, noisy(q, 0.05)), u, q)
    assert error.mean() <= 0.03
    assert error.max() <= 0.3


@pytest.mark.parametrize("case", HARD_AT_50_HZ.values(), ids=HARD_AT_50_HZ)
def test_noise_at_50_hz_is_survived(case):
    u, q = case
    error = errors_of(fitted(u, noisy(q, 0.1)), u, q)
    assert error.mean() <= 0.2
    assert error.max() <= 1.0


@pytest.mark.parametrize("rate", [50, 100])
@pytest.mark.parametrize("motion", [turn, about_turning_axis])
def test_anchored_takes_strong_noise_no_worse_than_lifted(motion, rate):
    """Noise of 0.05 rad at 50 Hz: 3.5 degrees against 2.0 when the curve follows the noise."""
    u, q = motion(90, rate)
    shaken = noisy(q, np.degrees(0.05))
    ours, theirs = (
        errors_of(fitted(u, shaken, orientation=name), u, q) for name in ("anchored", "lifted")
    )
    assert ours.mean() <= 1.02 * theirs.mean() <= 2.3
    assert ours.max() <= 1.05 * theirs.max()


@pytest.mark.parametrize("orientation", ["anchored", "lifted", "log", "euler"])
def test_small_rotations_are_replayed_by_every_representation(orientation):
    u, q = turn(60, 100)
    skill = fitted(u, q, orientation=orientation)
    assert errors_of(skill, u, q).max() < 0.1
    start, goal = moved_goal(q[:1], 10), moved_goal(q, 20)
    query = {"start": ((0, 0, 0), start), "goal": ((1, 0, 0), goal)}
    made = skill.generate(**query, duration=DURATION)
    ends = rotations.distance(made.orientations[[0, -1]], np.array([start, goal]))
    np.testing.assert_allclose(ends, 0.0, atol=1e-7)
    slow = skill.generate(**query, duration=2.0 * DURATION, dt=0.02)
    np.testing.assert_allclose(slow.orientations, made.orientations, atol=1e-12)
    np.testing.assert_allclose(slow.positions, made.positions, atol=1e-12)


def test_tool_that_only_turns_or_only_moves_is_learned():
    u, q = turn(120, 100)
    still = lt.PoseTrajectory(u, np.zeros((len(u), 3)), q)
    made = lt.DMP().fit([lt.Demonstration(still)]).generate()
    np.testing.assert_allclose(made.positions, 0.0, atol=1e-12)
    assert rotations.distance(made.orientations[-1:], q[-1:])[0] < 1e-7
    stiff = lt.PoseTrajectory(u, positions(u), np.repeat(q[:1], len(u), axis=0))
    made = lt.DMP().fit([lt.Demonstration(stiff)]).generate()
    assert angle_turned(made.orientations) < 1e-6


def test_several_demonstrations_give_their_mean():
    u, q = about_turning_axis(200, 100)
    spin = rotations.exp(np.radians([[0.0, 0.0, 10.0], [0.0, 0.0, -10.0]]))
    shown = [
        demonstration(u, rotations.compose(np.repeat(each[None], len(q), axis=0), q))
        for each in spin
    ]
    made = lt.DMP().fit(shown).generate(dt=DURATION / (len(u) - 1))
    assert np.degrees(rotations.distance(made.orientations, q)).max() < 0.01
    turned = rotations.compose(q, np.repeat([[0.0, 1.0, 0.0, 0.0]], len(q), axis=0))
    with pytest.raises(FitError, match="mean orientation"):
        lt.DMP().fit([shown[0], demonstration(u, turned)])


@pytest.mark.parametrize("trial", ["trial1.csv", "trial2.csv"])
def test_motions_of_a_real_robot_are_replayed(recordings, trial):
    columns = {
        "positions": [f"current_pos_{axis}" for axis in "xyz"],
        "orientations": [f"current_orientation_{axis}" for axis in "wxyz"],
    }
    path = recordings / "panda_execution" / trial
    recording = lt.read_motion(path, columns=columns, rate=20.0)
    motions = segment(recording)
    assert len(motions) > 30
    for shown in motions:
        motion = shown.motion
        # Two motions of 20 s have more to them than 50 kernels can say.
        skill = lt.DMP(weights=max(50, int(4 * motion.duration))).fit([shown])
        made = skill.generate(dt=motion.duration / (len(motion.times) - 1))
        gaps = np.linalg.norm(made.positions - motion.positions, axis=1)
        assert np.sqrt(np.mean(gaps**2)) <= 1e-3
        angles = rotations.distance(made.orientations, motion.orientations)
        assert np.degrees(angles).mean() <= 0.2


def test_a_long_motion_of_much_detail_is_replayed_with_as_many_kernels_as_it_asks_for():
    times = np.linspace(0.0, 20.0, 401)
    waves = np.column_stack([np.sin(2.0 * np.pi * f * times) for f in (0.3, 0.7, 1.1)])
    turned = rotations.exp(0.3 * waves)
    shown = lt.PoseTrajectory(times, 0.05 * waves, turned)
    away = []
    for weights in (50, None):
        made = lt.DMP(weights).fit([lt.Demonstration(shown)]).generate(dt=0.05)
        away.append(np.linalg.norm(made.positions - shown.positions, axis=1).max())
    assert away[1] < 0.2 * away[0]
