"""Published scenes for a Panda: distances and verdicts of coal, connections that are certified."""

import numpy as np
import pytest
from arm.motion_bench_maker import KINDS, problems
from foreign_arms import ERD_PANDA, urdf_in_package

import leadthrough as lt
from leadthrough.whole_arm import way_between
from leadthrough_studies.coal_arm import CoalArm


def test_distances_and_verdicts_are_those_of_coal(recordings):
    arm, rng = lt.Arm.load("panda"), np.random.default_rng(0)
    peer = CoalArm(arm)
    for _, _, problem in problems(recordings, [1]):
        some = rng.uniform(arm.limits.lower, arm.limits.upper, (4, 7))
        rows = np.vstack([problem.start, problem.goal, some])
        solids = [peer.solid(shape) for shape in problem.obstacles]
        clear = arm.is_clear(rows, problem.obstacles)
        ours = arm.distance(rows, problem.obstacles)
        for q, found, verdict in zip(rows, ours, clear, strict=True):
            peer.place(q)
            theirs = min(peer.distance_to(peer.moving_links(), *each) for each in solids)
            itself = min(peer.link_distance(*pair) for pair in arm.collision_pairs.checked)
            assert verdict == (min(theirs, itself) > -1e-6)
            if theirs > 0:
                assert found == pytest.approx(theirs, abs=1e-7)
            else:
                assert found < 1e-6


def test_what_rrt_connect_solves_is_solved_and_certified(recordings):
    """The hand stands at what it is to grasp, between its open fingers."""
    pytest.importorskip("ompl")
    urdf = urdf_in_package(*ERD_PANDA)
    arm = lt.Arm.from_urdf(urdf, tip="panda_hand").hold({"panda_finger_joint1": 0.04})
    kinds = set(KINDS) - {"cage"}  # there a finger's hull stands in the thing
    # The fourth under a table is found touching between its configurations, twice.
    asked = [(kind, 1) for kind in kinds] + [("table_under_pick", 4)]
    for kind, number, problem in problems(recordings, [1, 4]):
        if (kind, number) in asked:
            ends = problem.start, problem.goal
            way = way_between(arm, *ends, obstacles=problem.obstacles, margin=0.0)
            np.testing.assert_array_equal(way[[0, -1]], ends)
            assert arm.check(way, problem.obstacles).ok
