"""A wrong type, or a value that nothing can be made of, is refused by name in every part."""

from pathlib import Path

import numpy as np
import pytest
from motions import arm, minimum_jerk, reach
from refusals import refused

import leadthrough as lt
from leadthrough import arm as arms, planning, trajectories
from leadthrough.errors import FitError, IkFailure, LimitsInfeasible
from leadthrough.guard.ros import message_of

LINE = lt.Trajectory(np.linspace(0.0, 1.0, 50), np.outer(np.linspace(0.0, 1.0, 50), [1.0, 0.5]))
TURNS = lt.rotations.exp([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
REST = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])
UR3 = arm("ur3")
LIMITS_FILE = Path(__file__).parents[3] / "robots" / "ur3" / "limits.toml"
LAW = trajectories.linear([0.0, 1.0], [[0.0], [1.0]])
MEAN = lt.ProMP(weights=5).fit([LINE])


def test_what_is_no_path_is_named():
    refused("path: expected a path, got 3", lt.read_point_cloud, 3, radius=0.01)
    refused("path: expected a path, got None", lt.read_mesh, None)


def test_what_is_no_arm_is_named():
    refused("arm: expected an Arm, got None", arms.TaskStack, None, [])
    refused("arm: expected an Arm, got None", lt.DifferentialIk, None)


def test_what_is_no_skill_or_model_is_named():
    refused("skill: expected a skill, as `fit` returns, got list", lt.validate, [LINE], UR3)
    refused("skill: ", lt.augment, [LINE], UR3, episodes=1, out="never")
    for wrong in (3, [UR3], np.zeros(3), None):
        refused("candidates: expected models or their names", lt.learn, [LINE], candidates=wrong)


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
@pytest.mark.parametrize("model", [lt.DMP(weights=10), lt.RhythmicDMP(weights=10)])
def test_what_is_no_state_is_named(model):
    refused("state: expected one from begin or step, got str", model.fit([LINE]).step, "x", 0.01)


@pytest.mark.parametrize(
    "curve",
    [
        trajectories.Bezier([[0.0, 0.0], [1.0, 1.0]]),
        trajectories.Lagrange([0.0, 1.0], [[0.0], [1.0]]),
        trajectories.Spline([0.0, 1.0], np.ones((1, 2, 1))),
        trajectories.Slerp([0.0, 1.0], TURNS),
    ],
)
def test_ragged_times_of_a_curve_are_refused(curve):
    refused("t: expected a regular array", curve.evaluate, [[1, 2, 3], [4, 5]])


OPEN = np.ones((4, 4))


@pytest.mark.parametrize(
    ("message", "call"),
    [
        ("grid: expected a Grid", lambda x: planning.ArrivalField(OPEN, x, [0.0, 0.0])),
        ("grid: expected a Grid", lambda x: planning.descend(OPEN, x, [0.0, 0.0], [0.3, 0.3])),
        ("grid: expected a Grid", lambda x: planning.direction(OPEN, x, [[0.0, 0.0]])),
        ("grid: expected a Grid", lambda x: planning.fm2_speed(x, OPEN > 2.0, saturation=0.5)),
        ("grid: expected a Grid", lambda x: planning.occupied(x, [])),
        ("grid: expected a Grid", lambda x: planning.occupied_by_points(x, [[0, 0]], radius=0.1)),
        ("grid: expected a Grid", lambda x: planning.plan(OPEN, x, [0.0, 0.0], [0.3, 0.3])),
        ("arm: expected an Arm", lambda x: lt.connect(REST, lt.retime([REST], UR3.limits), x)),
        ("urdf: expected a JointLimits", lambda x: arms.read_limits(LIMITS_FILE, x)),
        ("path: expected a curve", lambda x: trajectories.run_by(x, LAW)),
        ("law: expected a curve", lambda x: trajectories.run_by(LAW, x)),
        ("skill: expected a skill", lambda x: lt.models.generate_all(x, [{}])),
        ("skill: expected a skill", lambda x: lt.models.reproduction(x, [LINE])),
        ("skill: expected a skill", lambda x: lt.plan_motion(x, UR3)),
        ("columns: expected a sequence", lambda x: MEAN.condition(0.5, [0.1], columns=x)),
        ("trajectory: expected a JointTrajectory", message_of),
    ],
)
def test_another_object_than_the_one_that_is_asked_for_is_named(message, call):
    for other in (3, "x", object(), lt.DMP):
        refused(message, call, other)


def test_demonstrations_of_another_kind_than_the_skill_are_refused():
    skill = lt.DMP(weights=10).fit([LINE])
    poses = lt.PoseTrajectory(LINE.times, np.eye(3)[np.arange(50) % 3], np.eye(4)[[0] * 50])
    refused(
        "expected motions as the skill's, Trajectory of 2", lt.models.reproduction, skill, [poses]
    )


class Tensor:
    """A tensor on another device, or under differentiation, refuses to be an array."""

    def __array__(self, *_, **__):
        raise RuntimeError("can't call numpy() on a tensor that requires grad")


ODD = [
    Tensor(), [[1.0], [2.0, 3.0]], [10**400, 1.0], [1j, 0j], ["1", "2"], [None, 1.0], np.ndarray,
    np.array([True, False]), np.array([1, 2], "M8[s]"), np.zeros(2, [("x", float)]), [np.nan, 0.0],
]  # fmt: skip
STATE = trajectories.FilterState.at_rest([0.0, 0.0])


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("positions", lambda x: lt.Trajectory([0.0, 1.0], x)),
        ("time", LINE.at),
        ("position", lambda x: lt.Sphere(0.1, x)),
        ("q", arm("ur3").forward_kinematics),
        ("q0", lambda x: arm("ur3").inverse_kinematics(np.zeros(3), q0=x)),
        ("goal", lambda x: lt.DMP(weights=10).fit([LINE]).generate(goal=x)),
        ("time", lambda x: lt.ProMP(weights=5).fit([LINE]).condition(x, [0.1, 0.1])),
        ("target", lambda x: trajectories.JerkFilter(1.0, 1.0, 1.0).step(STATE, x, 0.1)),
        ("velocity", lambda x: trajectories.TimeOptimalFilter(x, 1.0)),
        ("u", trajectories.minimum_jerk_time_scaling),
        ("speed", lambda x: lt.arrival_times(x, [[0, 0]])),
        ("obstacles", lambda x: lt.Scene([x])),
    ],
)
def test_what_is_no_array_of_numbers_is_refused_by_name(name, call):
    for value in ODD:
        refused(f"^{name}", call, value)


@pytest.mark.parametrize(
    "given",
    [
        lambda a: a.astype(">f8"),
        lambda a: a[::-1].copy()[::-1],
        lambda a: np.repeat(a, 2, axis=0)[::2],
        np.asfortranarray,
        lambda a: a.view(np.recarray),
        lambda a: np.frombuffer(b"x" + a.tobytes(), np.uint8)[1:].view(float).reshape(a.shape),
        memoryview,
    ],
)
def test_numbers_in_any_layout_are_the_same_numbers(given):
    made, ur3 = LINE.positions.copy(), arm("ur3")
    np.testing.assert_array_equal(lt.Trajectory(LINE.times, given(made)).positions, made)
    rows = np.outer(np.linspace(0.0, 1.0, 5), REST)
    one, other = (ur3.forward_kinematics(each)[0] for each in (rows, given(rows)))
    np.testing.assert_array_equal(one, other)
    for row in rows[1:2]:
        np.testing.assert_array_equal(ur3.jacobian(row), ur3.jacobian(given(row)))


def test_limits_and_rates_without_an_end_are_refused():
    motion = lt.JointTrajectory([0.0, 1.0], [[0.0], [1.0]])
    refused(
        "rate: .* >= 0.001",
        lt.retime,
        motion,
        lt.arm.JointLimits("a", *np.ones((5, 1))),
        rate=5e-324,
    )
    refused(
        "no motion ends",
        trajectories.double_s,
        [0.0],
        [1.0],
        velocity=5e-324,
        acceleration=1.0,
        jerk=1.0,
    )
    refused("skill: expected a skill", lt.plan_motion, "skill.npz", arm("ur3"))
    refused("queries: expected a sequence", lt.models.generate_all, MEAN, 3)


def test_times_whose_rates_overflow_are_refused():
    refused(
        "times: expected steps of at least 1e-60 s",
        lt.JointTrajectory,
        [0.0, 1e-300, 2e-300],
        [[0.0], [1.0], [2.0]],
    )


def test_a_fast_marching_file_with_an_empty_path_is_refused(tmp_path):
    lt.FastMarching().fit([LINE]).save(tmp_path / "skill.npz")
    with np.load(tmp_path / "skill.npz") as file:
        np.savez(tmp_path / "empty.npz", **{**file, "path_0": np.empty((0, 2))})
    refused("path", lt.load_skill, tmp_path / "empty.npz")


def test_a_motion_smaller_than_squares_can_hold_is_refused():
    with pytest.raises(FitError, match="use another unit"):
        lt.FastMarching().fit([lt.Trajectory(LINE.times, 1e-160 * LINE.positions)])


def test_a_folder_of_recordings_is_read_whole(tmp_path):
    for number in range(3):
        lt.write_motion(reach("poses", number), tmp_path / f"reach{number}.csv")
    (tmp_path / "notes.pdf").write_text("nothing to read")
    found = lt.read_demonstrations(tmp_path)
    assert [each.name for each in found] == ["reach0", "reach1", "reach2"]
    (tmp_path / "empty").mkdir()
    refused("nothing to read in this folder", lt.read_demonstrations, tmp_path / "empty")


def test_joints_in_degrees_are_asked_for():
    ur3 = arm("ur3")
    moved = np.degrees(REST + np.outer([0.0, 1.0], [0.1, 0.2, 0.1, 0.0, 0.1, 0.0]))
    with pytest.raises(LimitsInfeasible, match=r"degrees\?"):
        lt.retime(moved, ur3.limits)
    with pytest.warns(UserWarning, match=r"degrees\?"):
        ur3.check(moved)


def test_a_start_without_room_is_reported_of_an_arm_with_an_endless_joint():
    ur3, times = arm("ur3"), np.linspace(0.0, 2.0, 40)
    q = REST + np.outer(minimum_jerk(times / 2.0), [0.6, 0.2, -0.3, 0.25, 0.15, 0.8])
    tip = ur3.poses(lt.JointTrajectory(times, q))
    shown = lt.PoseTrajectory(times, tip.positions, tip.orientations)
    skill = lt.ProMP(weights=5).fit([shown])
    assert not np.isfinite(ur3.limits.upper).all()
    with pytest.raises(IkFailure, match="no collision-free configuration found at the start"):
        lt.plan_motion(skill, ur3, [lt.Sphere(0.05, tip.positions[0])])
