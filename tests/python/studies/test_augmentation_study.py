"""A policy from three demonstrations and from episodes made of them: the data and the judge."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from leadthrough.motion import PoseTrajectory
from leadthrough.simulation import SimulatedArm
from leadthrough_studies.augmentation.episodes import (
    CHUNK,
    DATA_SETS,
    GOALS,
    HOME,
    demonstrations,
    disturbed,
    followed,
    shifted,
    solved,
)
from leadthrough_studies.augmentation.policy import Policy, reach
from leadthrough_studies.augmentation.report import report
from leadthrough_studies.augmentation.study import STUDY, AugmentationConfig
from leadthrough_studies.study import run, selected

GOAL = np.array([0.55, 0.1, 0.2])  # m


@pytest.fixture(scope="module")
def shown(panda):
    return demonstrations(panda, np.random.default_rng(0))


def as_matrices(motion):
    found = np.tile(np.eye(4), (len(motion.times), 1, 1))
    wxyz = motion.orientations
    found[:, :3, :3] = Rotation.from_quat(wxyz[:, [1, 2, 3, 0]]).as_matrix()
    found[:, :3, 3] = motion.positions
    return found


def test_a_segment_keeps_its_poses_relative_to_the_goal(shown):
    source = shown[0]
    turn = Rotation.from_euler("xyz", [0.2, -0.1, 0.5]) * Rotation.from_quat(
        source.orientations[-1][[1, 2, 3, 0]]
    )
    moved = shifted(source, GOAL, turn.as_quat()[[3, 0, 1, 2]])
    before, after = as_matrices(source), as_matrices(moved)
    assert after[-1, :3, 3] == pytest.approx(GOAL)
    assert after[-1, :3, :3] == pytest.approx(turn.as_matrix())
    half = len(before) // 2
    relative = [np.linalg.inv(rows[-1]) @ rows[half:] for rows in (before, after)]
    assert relative[1] == pytest.approx(relative[0], abs=1e-9)


def test_the_way_to_a_segment_is_straight_from_the_start(shown):
    moved = shifted(shown[1], GOAL, shown[1].orientations[-1])
    half = len(moved.times) // 2
    assert moved.positions[0] == pytest.approx(shown[1].positions[0])
    steps = np.diff(moved.positions[: half + 1], axis=0)
    assert steps == pytest.approx(np.tile(steps[0], (len(steps), 1)), abs=1e-12)


def test_poses_out_of_reach_are_discarded(panda, shown):
    assert solved(panda, shown[0]) is not None
    far = shown[0].positions + np.linspace(0.0, 1.0, len(shown[0].times))[:, None]
    assert solved(panda, PoseTrajectory(shown[0].times, far, shown[0].orientations)) is None


def test_chunks_of_a_disturbed_state_lead_back_to_the_path():
    q = np.linspace(0.0, 1.0, 50)[:, None] * np.ones(7)
    path, wanted = followed(q)
    states, chunks = disturbed(q, np.random.default_rng(0))
    away = states - path
    assert 0.02 < away.std() < 0.1
    assert np.abs(away[[0, -1]]).max() < 1e-12
    assert chunks[:, -1] == pytest.approx(wanted[:, -1])
    step = chunks[:, 0] - wanted[:, 0]
    assert np.abs(step - away).max() < 1e-3 * np.abs(away).max()
    left = np.linalg.norm(chunks - wanted, axis=2)
    assert (np.diff(left, axis=1) <= 1e-12).all()


def test_chunks_are_the_rows_that_follow_and_end_at_rest():
    q = np.arange(40.0)[:, None]
    states, chunks = followed(q)
    assert len(states) == 40 + CHUNK
    assert chunks[3, :, 0] == pytest.approx(np.arange(4, 4 + CHUNK))
    assert (chunks[-1] == 39.0).all()


@pytest.mark.parametrize("name", ["ours", "shifting"])
def test_episodes_begin_at_home_and_end_at_goals_all_over_the_region(panda, shown, name):
    episodes = DATA_SETS[name](panda, shown, 12, 0)
    assert len(episodes) == 12
    # Written data sets hold single precision, and inverse kinematics its tolerance.
    assert np.abs([states[0] - HOME for states, _ in episodes]).max() < 1e-4
    ends = panda.forward_kinematics(np.array([states[-1] for states, _ in episodes]))[0]
    assert all(GOALS.contains(end) for end in ends)
    assert (np.ptp(ends, axis=0) > 0.5 * (GOALS.upper - GOALS.lower)).all()


def test_every_data_set_is_trained_on_as_many_rows(panda, shown):
    short = DATA_SETS["demonstrations"](panda, shown, 0, 0)
    long = DATA_SETS["noise"](panda, shown, 30, 0)
    seen = [Policy(panda, each, 2, 0)._network.t_ for each in (short, long)]
    assert seen == [20000, 20000]


class ToGoal:
    """Chunks that lead to a configuration at the goal, or stay away from it by some radians."""

    def __init__(self, arm, off):
        self.arm, self.off = arm, off

    def chunk(self, q, goal):
        orientation = self.arm.forward_kinematics(HOME)[1]
        end = self.arm.inverse_kinematics(goal, orientation, q0=HOME).q + self.off
        return np.linspace(0.0, 1.0, CHUNK + 1)[1:, None] * (end - q)


@pytest.mark.parametrize(("off", "success"), [(0.0, 1), (0.1, 0)])
def test_a_reach_is_judged_by_its_end(panda, off, success):
    row = reach(panda, ToGoal(panda, off), GOAL)
    assert (row["success"], row["contacts"]) == (success, 0)
    assert (row["distance_m"] < 0.02) == bool(success)


def test_the_guard_stops_a_reach_into_the_table(panda):
    row = reach(panda, ToGoal(panda, 0.0), np.array([0.55, 0.0, -0.09]))
    assert (row["success"], row["contacts"]) == (0, 0)


def test_a_reach_with_a_contact_has_failed(panda, monkeypatch):
    monkeypatch.setattr(SimulatedArm, "touches", ["a body"])
    row = reach(panda, ToGoal(panda, 0.0), GOAL)
    assert row["distance_m"] < 0.02
    assert row["contacts"] > 0
    assert row["success"] == 0


class Restless(ToGoal):
    """The same with an oscillation of all joints at 3 Hz."""

    def chunk(self, q, goal):
        shaking = 0.01 * np.sin(0.2 * np.pi * np.arange(1, CHUNK + 1))[:, None]
        return super().chunk(q, goal) + shaking


def test_a_reach_that_does_not_come_to_rest_has_failed(panda):
    row = reach(panda, Restless(panda, 0.0), GOAL)
    assert row["distance_m"] < 0.02
    assert row["speed"] > 0.05
    assert row["success"] == 0


def rows_of(data, training, hits):
    return [
        {"data": data, "training": training, "episodes": 3, "success": int(i < hits)}
        | {"distance_m": 0.01 if i < hits else 0.3, "speed": 0.0, "contacts": 0}
        for i in range(50)
    ]


def wilson(hits, count, z=1.959963984540054):
    middle = (hits + z**2 / 2) / (count + z**2)
    half = z / (count + z**2) * np.sqrt(hits * (count - hits) / count + z**2 / 4)
    return pytest.approx((100 * (middle - half), 100 * (middle + half)))


def test_intervals_are_wilsons_and_that_of_all_holds_every_one():
    config = AugmentationConfig(data=("noise", "ours"), goals=50, trainings=2)
    hits = {("noise", 0): 5, ("noise", 1): 10, ("ours", 0): 45, ("ours", 1): 40}
    found = report(config, [row for key, n in hits.items() for row in rows_of(*key, n)])
    for (data, training), n in hits.items():
        (row,) = selected(found.table, data=data, training=str(training))
        assert (row["low"], row["high"]) == wilson(n, 50)
    (both,) = selected(found.table, data="ours", training="all")
    assert both["percent"] == 85.0
    assert (both["low"], both["high"]) == (wilson(40, 50).expected[0], wilson(45, 50).expected[1])
    gap = wilson(40, 50).expected[0] - wilson(10, 50).expected[1]
    assert found.summary == {"ours_above_noise": pytest.approx(gap)}


def test_the_study_runs_and_gives_the_same_rows_again(tmp_path):
    config = AugmentationConfig(("demonstrations", "ours"), 3, 1, 2, 1)
    first, again = (run(STUDY, config, out=tmp_path / name) for name in "ab")
    assert not first.failures
    assert first.rows == again.rows
    assert [row["data"] for row in first.rows] == ["demonstrations"] * 2 + ["ours"] * 2
