"""Standing still at the ends of recordings, on the command line."""

import numpy as np
from cli.command_line import facts, run

import leadthrough as lt


def standing_still():
    """How long the learned motion moves slower than a hundredth of its highest speed, s."""
    motion = lt.load_skill("reach.npz").generate()
    speeds = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1) / np.diff(motion.times)
    return np.diff(motion.times)[speeds < 0.01 * speeds.max()].sum()


def test_a_learned_motion_does_not_stand_still(folder):
    told = run("learn", "shown", "-o", "reach.npz").stderr
    assert told.count("stood still, left out") == 3
    assert standing_still() < 0.2
    run("learn", "shown", "--rest", "inf", "-o", "reach.npz")
    assert standing_still() > 0.8


def test_many_recordings_are_told_of_in_one_line(folder):
    many = [f"shown/reach{1 + number % 3}.csv" for number in range(9)]
    told = run("learn", *many, "-o", "reach.npz").stderr
    assert told.count("stood still") == 1
    assert "9 recordings: stood still, left out up to 1.54 s of each (--rest)" in told


def test_speed_and_rest_are_options(folder):
    run("learn", "shown", "--rest", "0.4", "-o", "reach.npz")
    assert standing_still() > 0.5
    assert "--speed: " in run("learn", "shown", "--speed", "-1", "-o", "x.npz", code=2).stderr
    assert "--rest: " in run("learn", "shown", "--rest", "-1", "-o", "x.npz", code=2).stderr


def test_a_cleaned_recording_begins_with_the_motion(folder):
    (found,) = facts("clean", "shown/reach1.csv", "-o", "clean.csv")
    assert min(found["report"]["still"]) > 0.2
    (found,) = facts("clean", "shown/reach1.csv", "--rest", "inf", "-o", "clean.csv")
    assert found["report"]["still"] == [0.0, 0.0]
    (found,) = facts("clean", "shown/reach1.csv", "--pause", "9", "-o", "clean.csv")
    assert found["report"]["pauses"] == []
