"""Inputs too large or in a wrong unit, frame or order are refused or warned of, with the cure."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from refusals import raised, refused

import leadthrough as lt
from leadthrough.errors import IkFailure, InvalidInput
from leadthrough.sanity import ImplausibleInputWarning

ROBOTS = Path(__file__).parents[2] / "robots"
T = np.linspace(0.0, 3.0, 150)
WAY = lt.trajectories.minimum_jerk_time_scaling(T / 3.0)
DOWN = np.array([0.0, 1.0, 0.0, 0.0])
START, GOAL = np.array([0.4, -0.2, 0.4]), np.array([0.45, 0.25, 0.3])


def reach(goal=GOAL, orientation=DOWN):
    points = START + np.outer(WAY, np.asarray(goal) - START)
    return lt.PoseTrajectory(T, points, np.tile(orientation, (len(T), 1)))


@pytest.fixture(scope="module", params=["dmp", "promp", "gmr", "marching"])
def skill(request):
    models = {"dmp": lt.DMP(), "promp": lt.ProMP(), "gmr": lt.GMR(components=3)}
    return models.get(request.param, lt.FastMarching()).fit([reach(), reach(GOAL + 0.01)])


@pytest.mark.parametrize("name", ["start", "goal"])
def test_a_place_in_millimetres_is_refused(skill, name):
    with pytest.raises(InvalidInput, match=rf"{name}: \(450, 250, 300\) lies .* \(m, not mm\)"):
        skill.generate(**{name: (1000.0 * GOAL, DOWN)})
    skill.generate(goal=(3.0 * GOAL, DOWN))  # far, and in m


def test_a_point_to_pass_in_millimetres_is_refused():
    demonstrations = [reach(), reach(GOAL + 0.01)]
    dmp, promp = lt.DMP().fit(demonstrations), lt.ProMP().fit(demonstrations)
    middle = 0.5 * (START + GOAL)
    for passing, name in (
        (lambda point: dmp.generate(via=[(0.5, point)]), "via"),
        (lambda point: promp.condition(1.5, point), "position"),
        (lambda point: promp.corrected(1.5, point), "position"),
    ):
        passing(middle + 0.01)
        refused(rf"{name}: .* \(m, not mm\)", passing, 1000.0 * middle)


def test_a_goal_many_extents_away_is_warned_of(skill):
    """Three numbers are a position: nobody knows yet whether an arm reaches it."""
    with pytest.warns(ImplausibleInputWarning, match=r"goal: \(1, 2, 3\) lies 2.6 from a motion"):
        skill.generate(goal=(1.0, 2.0, 3.0))


def test_an_obstacle_in_millimetres_is_warned_of():
    skill = lt.DMP().fit([reach()])
    with pytest.warns(
        ImplausibleInputWarning, match=r"obstacles\[1\]: lies at .* \(m, not mm\)"
    ) as told:
        skill.generate(obstacles=[table(), lt.Sphere(80.0, (0.0, 0.0, 400.0))])
    assert told[0].filename == __file__


def table():
    return lt.Box((9.0, 9.0, 0.1), (0.0, 0.0, -0.1))


def test_a_quaternion_in_the_other_order_is_warned_of(skill):
    with pytest.warns(
        ImplausibleInputWarning, match=r"goal: the orientation .* give quaternions as w, x, y, z"
    ):
        skill.generate(goal=(GOAL, DOWN[[1, 2, 3, 0]]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skill.generate(goal=(GOAL, lt.rotations.exp([[0.0, 0.0, 3.0]])[0]))  # turned, and meant


def test_joints_in_degrees_are_refused(panda):
    turn = np.array([0, 0, 0, -1.5, 0, 1.5, 0]) + np.outer(WAY, np.full(7, 0.3))
    skill = lt.DMP().fit([lt.JointTrajectory(T, turn, joint_names=panda.joint_names)])
    goal = np.degrees(turn[-1])
    refused(r"goal: number 6 is 103.1 rad.* not degrees", skill.generate, goal=goal)
    degrees = lt.JointTrajectory(T, np.degrees(turn), joint_names=panda.joint_names)
    refused(r"panda_joint\d goes to .*angles='degrees'", panda.poses, degrees)
    with pytest.warns(ImplausibleInputWarning, match="angles='degrees'"):
        panda.joints_of(degrees)
    panda.poses(lt.JointTrajectory(T, turn + 0.1, joint_names=panda.joint_names))


def test_a_urdf_in_degrees_is_warned_of():
    text = (ROBOTS / "ur3/ur3.urdf").read_text()
    in_degrees = re.sub(
        r'(lower|upper)="([-\d.e]+)"',
        lambda found: f'{found[1]}="{np.degrees(float(found[2]))}"',
        text,
    )
    assert in_degrees != text
    with pytest.warns(ImplausibleInputWarning, match="limits: the URDF .* degrees"):
        lt.Arm.from_urdf(in_degrees, tip="tool0")


def test_a_step_longer_than_the_motion_is_refused(skill):
    refused(r"dt: expected at most the motion's .* got 10", skill.generate, dt=10.0)


@pytest.mark.parametrize("step", [1.0, 2.0, 10.03, 20.0])
def test_times_in_milliseconds_are_warned_of(step, tmp_path):
    shown = reach()
    in_ms = lt.PoseTrajectory(step * np.arange(len(T)), shown.positions, shown.orientations)
    with pytest.warns(
        ImplausibleInputWarning, match=rf"demonstrations\[0\]: one sample in {step:g} s"
    ):
        lt.DMP().fit([in_ms])
    lt.write_motion(in_ms, tmp_path / "in_ms.csv")
    with pytest.warns(ImplausibleInputWarning, match=f"in_ms.csv: one sample in {step:g} s"):
        lt.read_motion(tmp_path / "in_ms.csv")


def test_a_clock_that_jumps_by_an_hour_is_warned_of():
    shown = reach()
    times = shown.times + 3600.0 * (np.arange(len(T)) > 20)
    with pytest.warns(
        ImplausibleInputWarning, match=r"demonstrations\[0\]: no sample from .* to 36"
    ):
        lt.DMP().fit([lt.PoseTrajectory(times, shown.positions, shown.orientations)])


@pytest.mark.parametrize("beyond", [0.1, 0.5])
def test_an_unreachable_goal_says_by_how_much(panda, beyond):
    shoulder = np.array([0.0, 0.0, 0.333])
    way = np.array([0.8, 0.6, 0.0])
    goal = shoulder + way * (panda._chain.reach + beyond)
    with pytest.raises(IkFailure, match=rf"up to {beyond:g} m beyond the arm's reach") as failure:
        panda.follow(reach(goal))
    assert failure.value.status == "unreachable"
    assert f"sample {failure.value.index}" in str(failure.value)
    assert "in m, not mm" in str(raised(IkFailure, panda.follow, reach(1000.0 * GOAL)))


def test_an_unreachable_goal_names_the_joint_whose_limit_is_in_the_way(panda):
    with pytest.raises(IkFailure, match=r"panda_joint\d at its (lower|upper) limit") as failure:
        panda.follow(reach((0.9, 0.3, 0.4)))
    assert failure.value.status == "limits"
    assert failure.value.index == len(T) - 1
    assert failure.value.residual[0] > 0.01


def test_an_obstacle_in_millimetres_is_warned_of_by_the_arm(panda):
    home = [[0, 0, 0, -1.5, 0, 1.5, 0]]
    for wrong in (lt.Sphere(0.1, (400.0, 0.0, 300.0)), lt.Sphere(80.0, (0.4, 0.0, 0.3))):
        with pytest.warns(ImplausibleInputWarning, match=r"obstacles\[0\]: .* in m, not mm"):
            panda.check(home, [wrong])
    assert panda.check(home, [table()]).ok


VAST = np.broadcast_to(np.float64(1.0), (10**6, 10**6))  # takes eight bytes itself


@pytest.fixture(scope="module")
def demonstrations():
    times = np.linspace(0.0, 1.0, 50)
    return [lt.Demonstration(lt.Trajectory(times, np.column_stack([times, times**2])))] * 3


@pytest.fixture(scope="module")
def promp(demonstrations):
    return lt.ProMP().fit(demonstrations)


def test_points_of_a_mixture_are_counted_too(demonstrations):
    mixture = lt.GMR(components=2).fit(demonstrations).mixture
    refused(r"count: expected at most .*, got 1,000,000,000", mixture.sample, 10**9, seed=0)
    assert mixture.sample(1000, seed=0).shape == (1000, 3)


@pytest.mark.parametrize("count", [0, 1_000_001])
@pytest.mark.parametrize("model", [lt.ProMP(), lt.GMR(components=2)], ids=["ProMP", "GMR"])
def test_a_distribution_at_no_or_too_many_times_is_refused(demonstrations, model, count):
    skill = model.fit(demonstrations)
    with pytest.raises(InvalidInput, match=rf"times: expected 1 to 1,000,000 times, got {count:,}"):
        skill.distribution(np.zeros(count))


def test_what_is_too_large_is_refused_with_its_size(promp):
    for count in [10**6, 10**12, 10**30]:
        refused(rf"count: .* got {count:,}, which would take .* GiB", promp.sample, count, seed=0)
    for call, named in [
        (lambda: lt.Grid((0, 0), 1.0, (10**20, 10**20)), "shape: expected at most 2e"),
        (lambda: lt.arrival_times(VAST, [(0, 0)]), "speed: expected at most 2e"),
        (lambda: lt.planning.distance_transform(np.broadcast_to(True, VAST.shape)), "mask"),
        (lambda: lt.Arm.load("ur3").forward_kinematics(np.broadcast_to(0.0, (10**14, 6))), "q: an"),
        (lambda: lt.Trajectory(np.broadcast_to(0.0, (10**15,)), [[0.0]]), "times: an array"),
    ]:
        refused(named, call)


def test_a_skill_whose_head_nests_deep_is_refused(tmp_path):
    np.savez(tmp_path / "deep.npz", head=np.array("[" * 100_000))
    refused("path: expected a saved skill", lt.load_skill, tmp_path / "deep.npz")
