"""Paths inside velocity and acceleration limits, beside singularities, from random starts."""

import numpy as np
import pytest
from motions import minimum_jerk
from refusals import raised, refused
from scipy.interpolate import CubicSpline

import leadthrough as lt
from leadthrough.arm import FollowOptions
from leadthrough.errors import IkFailure, LimitsInfeasible

PANDA, UR3, TIAGO = (lt.Arm.load(name) for name in ("panda", "ur3", "tiago"))
ARMS = pytest.mark.parametrize("arm", [PANDA, UR3, TIAGO], ids=["panda", "ur3", "tiago"])

ON_RATE_LIMIT = pytest.mark.parametrize("on_rate_limit", ["exceed_limits", "slow", "raise"])
# Judged by differences of the samples.
ROUNDING = 1e-6


def line(arm, posture, direction, *, half, duration, samples=601):
    """Straight through a posture's pose from rest to rest, the tool not turning."""
    position, orientation = arm.forward_kinematics(posture)
    s = np.linspace(0.0, 1.0, samples)
    along = half * (2.0 * minimum_jerk(s) - 1.0)
    positions = position + np.outer(along, direction)
    return lt.PoseTrajectory(duration * s, positions, np.tile(orientation, (samples, 1)))


def past_the_wrist(distance, bend, duration=3.0):
    """A UR3's line that turns the hand past the forearm's axis at a small angle."""
    posture = np.array([0.0, -1.2, 1.4, bend, distance, 0.3])
    x, y, _ = UR3.forward_kinematics(posture)[0]
    sideways = np.array([-y, x, 0.0]) / np.hypot(x, y)
    return UR3, posture, line(UR3, posture, sideways, half=0.08, duration=duration)


def past_the_shoulder(duration=1.5):
    posture = np.array([0, 0.02, 1.57, -1.8, 0, 1.6, 0.7])
    directions = np.linalg.svd(np.linalg.pinv(PANDA.jacobian(posture))[:, :3])[2]
    return PANDA, posture, line(PANDA, posture, directions[0], half=0.12, duration=duration)


def towards_a_straight_elbow():
    """A UR3 stretches to within 0.1 mm of its reach and comes back."""
    posture = np.array([0.0, -1.2, 0.02, -1.7, -1.5, 0.3])
    shoulder_to_tip = UR3.forward_kinematics(posture)[0] - [0.0, 0.0, 0.15]
    outwards = shoulder_to_tip / np.linalg.norm(shoulder_to_tip)
    full = line(UR3, posture, outwards, half=0.06, duration=4.0)
    inside = full.positions - 0.06 * outwards
    there_and_back = lt.PoseTrajectory(
        np.concatenate([full.times, full.times[1:] + full.duration]),
        np.vstack([inside, inside[-2::-1]]),
        np.tile(full.orientations[0], (1201, 1)),
    )
    start = posture.copy()
    start[2] = 0.5
    return UR3, start, there_and_back


SINGULAR = {
    "wrist": lambda: past_the_wrist(0.01, 0.3927),
    "wrist, further": lambda: past_the_wrist(0.05, 0.0),
    "shoulder": past_the_shoulder,
    "elbow": towards_a_straight_elbow,
}


def plain_inverse(arm, motion, q):
    rows = [q]
    for goal, turned in zip(motion.positions[1:], motion.orientations[1:], strict=True):
        here, orientation = arm.forward_kinematics(rows[-1])
        back = lt.rotations.inverse(orientation[None])
        turn = lt.rotations.log(lt.rotations.compose(turned[None], back))[0]
        rows.append(rows[-1] + np.linalg.pinv(arm.jacobian(rows[-1])) @ [*(goal - here), *turn])
    return np.array(rows)


def speeds(arm, times, q):
    return np.abs(np.diff(q, axis=0)) / np.diff(times)[:, None] / arm.limits.velocity


def assert_inside_the_limits(arm, joints):
    """Between samples the joints move straight: differences of the samples are judged."""
    report = arm.path_report(joints, arm.poses(joints))
    assert report.margin.min() >= 0.0
    assert report.velocity_ratio.max() <= 1.0 + ROUNDING
    assert report.acceleration_ratio.max() <= 1.0 + ROUNDING


@pytest.mark.parametrize("where", ["wrist", "wrist, further", "shoulder"])
def test_beside_a_singularity_the_plain_inverse_jumps_and_follow_slows(where):
    arm, posture, motion = SINGULAR[where]()
    joints = arm.follow(motion, q0=posture, on_rate_limit="slow")
    assert speeds(arm, motion.times, plain_inverse(arm, motion, joints.positions[0])).max() > 2.0
    assert_inside_the_limits(arm, joints)
    assert arm.path_report(joints, motion, position_tolerance=1e-5, orientation_tolerance=1e-5).ok
    assert joints.times[0] == motion.times[0]
    assert (np.diff(joints.times) >= np.diff(motion.times) * (1 - 1e-9)).all()
    assert joints.duration < 1.6 * motion.duration  # slower at the fast part only


@pytest.mark.parametrize(
    ("where", "deviation"),
    [
        ("wrist", (1e-3, 1e-2)),
        ("wrist, further", (3e-3, 2e-2)),
        ("shoulder", (1e-3, 5e-3)),
        ("elbow", (1e-2, 2e-2)),
    ],
)
def test_beside_a_singularity_follow_deviates_by_no_more_than_stated_and_returns(where, deviation):
    arm, posture, motion = SINGULAR[where]()
    joints = arm.follow(motion, q0=posture, on_rate_limit="deviate", deviation=deviation)
    np.testing.assert_array_equal(joints.times, motion.times)
    assert_inside_the_limits(arm, joints)
    report = arm.path_report(joints, motion)
    assert report.position_error.max() <= deviation[0]
    assert report.orientation_error.max() <= deviation[1]
    assert report.position_error[-1] <= 1e-4
    assert report.orientation_error[-1] <= 1e-3


def test_a_deviation_that_is_not_enough_raises():
    arm, posture, motion = SINGULAR["wrist"]()
    with pytest.raises(IkFailure) as failure:
        arm.follow(motion, q0=posture, on_rate_limit="deviate", deviation=(1e-5, 1e-4))
    assert failure.value.status == "rate_limit"
    failure = raised(IkFailure, arm.follow, motion, q0=posture, on_rate_limit="raise")
    assert failure.status == "rate_limit"
    assert 200 < failure.index < 400


def random_path(arm, rng, samples=200):
    """Joints between random waypoints from rest to rest, at half of all limits at most."""
    lower = np.maximum(arm.limits.lower, -np.pi)
    upper = np.minimum(arm.limits.upper, np.pi)
    edge = 0.05 * (upper - lower)
    while True:
        way = [rng.uniform(lower + edge, upper - edge)]
        for _ in range(4):
            step = 0.15 * (upper - lower) * rng.uniform(-1.0, 1.0, len(lower))
            way.append(np.clip(way[-1] + step, lower + edge, upper - edge))
        spline = CubicSpline(np.linspace(0, 1, 5), way, bc_type="clamped")
        s = np.linspace(0.0, 1.0, samples)
        if (spline(s) > lower).all() and (spline(s) < upper).all():
            break
    speed = (np.abs(spline(s, 1)) / arm.limits.velocity).max()
    acceleration = (np.abs(spline(s, 2)) / arm.limits.acceleration).max()
    duration = max(speed / 0.5, np.sqrt(acceleration / 0.5))
    return lt.PoseTrajectory(duration * s, *arm.forward_kinematics(spline(s)))


@ARMS
def test_feasible_paths_are_followed_without_knowing_their_joints(arm):
    rng = np.random.default_rng(11)
    missed = samples = 0
    for _ in range(12):
        motion = random_path(arm, rng)
        joints = arm.follow(motion, on_rate_limit="slow")
        assert_inside_the_limits(arm, joints)
        report = arm.path_report(joints, motion)
        missed += ((report.position_error > 1e-4) | (report.orientation_error > 1e-3)).sum()
        samples += len(motion.times)
    assert missed <= 0.002 * samples


@pytest.mark.parametrize("arm", [PANDA, UR3], ids=["panda", "ur3"])
def test_feasible_paths_are_followed_at_their_own_pace(arm):
    rng = np.random.default_rng(12)
    for _ in range(8):
        motion = random_path(arm, rng)
        joints = arm.follow(motion, on_rate_limit="deviate", deviation=(0.02, 0.1))
        assert_inside_the_limits(arm, joints)
        assert arm.path_report(joints, motion).ok


def recorded(recordings, trial):
    columns = np.genfromtxt(
        recordings / "panda_execution" / f"trial{trial}.csv", delimiter=",", names=True
    )
    positions = np.stack([columns[f"current_pos_{axis}"] for axis in "xyz"], axis=1)
    turned = np.stack([columns[f"current_orientation_{axis}"] for axis in "wxyz"], axis=1)
    joints = np.stack([columns[f"joint_{i}"] for i in range(1, 8)], axis=1)
    return lt.PoseTrajectory(0.05 * np.arange(len(positions)), positions, turned), joints


@pytest.mark.parametrize("trial", [1, 2])
@ON_RATE_LIMIT
def test_recorded_poses_are_followed_inside_the_limits(recordings, trial, on_rate_limit):
    motion, shown = recorded(recordings, trial)
    joints = PANDA.follow(motion, on_rate_limit=on_rate_limit)
    report = PANDA.path_report(joints, motion)
    assert report.ok
    assert report.position_error.max() < 1e-5
    np.testing.assert_allclose(joints.times, motion.times, atol=1e-9)
    # The person's own joints moved by up to 0.074 rad between samples.
    assert np.abs(np.diff(shown, axis=0)).max() < 0.08
    assert np.abs(np.diff(joints.positions, axis=0)).max() < 0.08
    assert_inside_the_limits(PANDA, joints)


@pytest.mark.parametrize("arm", [PANDA, TIAGO], ids=["panda", "tiago"])
@ON_RATE_LIMIT
def test_the_pull_to_the_middle_moves_the_tool_by_less_than_a_micrometre(arm, on_rate_limit):
    q = 0.3 * arm.limits.lower + 0.7 * arm.limits.upper
    position, orientation = arm.forward_kinematics(q)
    times = np.linspace(0.0, 4.0, 401)
    still = lt.PoseTrajectory(times, np.tile(position, (401, 1)), np.tile(orientation, (401, 1)))
    joints = arm.follow(still, q0=q, on_rate_limit=on_rate_limit)
    reached, turned = arm.forward_kinematics(joints.positions)
    assert np.linalg.norm(reached - position, axis=1).max() < 1e-6
    assert lt.rotations.distance(turned, still.orientations).max() < 1e-6
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    # Inside the limits of velocity, distances count by the time that they take.
    unit = arm.limits.velocity if on_rate_limit == "raise" else 1.0
    away = np.linalg.norm((joints.positions - middle) / unit, axis=1)
    assert away[-1] < away[0] - 1e-3
    assert np.abs(joints.positions[-1] - q).max() > 0.05


@ARMS
@pytest.mark.parametrize("on_rate_limit", ["slow", "raise"])
def test_the_same_motion_gives_the_same_bits(arm, on_rate_limit):
    motion = random_path(arm, np.random.default_rng(1))
    first, again = (arm.follow(motion, on_rate_limit=on_rate_limit) for _ in range(2))
    np.testing.assert_array_equal(first.positions, again.positions)
    np.testing.assert_array_equal(first.times, again.times)


@ARMS
@ON_RATE_LIMIT
@pytest.mark.parametrize("count", [1, 2])
def test_one_pose_or_the_same_one_twice_stands_still(arm, on_rate_limit, count):
    q = arm.follow(random_path(arm, np.random.default_rng(0))).positions[0]
    position, orientation = arm.forward_kinematics(q)
    times = [0.0, 1e-3][:count]
    motion = lt.PoseTrajectory(times, [position] * count, [orientation] * count)
    joints = arm.follow(
        motion, q0=q, options=FollowOptions(nullspace_gain=0.0), on_rate_limit=on_rate_limit
    )
    np.testing.assert_allclose(joints.positions, np.tile(q, (count, 1)), atol=1e-5)
    np.testing.assert_allclose(joints.velocities, 0.0, atol=1e-2 if count > 1 else 0.0)
    np.testing.assert_array_equal(joints.times, times)


@ON_RATE_LIMIT
def test_half_a_turn_between_two_samples_is_no_path(on_rate_limit):
    position, orientation = PANDA.forward_kinematics([0, -0.5, 0, -2, 0, 1.6, 0.7])
    over = lt.rotations.compose(lt.rotations.exp([[0, np.pi, 0]]), orientation[None])[0]
    motion = lt.PoseTrajectory([0.0, 0.01], [position] * 2, [orientation, over])
    failure = raised(IkFailure, PANDA.follow, motion, on_rate_limit=on_rate_limit)
    assert failure.index == 1
    assert np.isfinite(failure.q).all()


@ON_RATE_LIMIT
@pytest.mark.parametrize("far", [10.0, 1e6, 1e150])
@ARMS
def test_a_far_target_is_unreachable(arm, on_rate_limit, far):
    with pytest.raises(IkFailure) as failure:
        arm.follow(lt.Trajectory([0.0, 1.0], [[far, 0, 0]] * 2), on_rate_limit=on_rate_limit)
    assert (failure.value.index, failure.value.status) == (0, "unreachable")


@pytest.mark.parametrize(
    "options",
    [
        {"on_rate_limit": "never"},
        {"on_rate_limit": None},
        {"on_rate_limit": "deviate"},
        {"on_rate_limit": "slow", "deviation": (0.1, 0.1)},
        {"on_rate_limit": "deviate", "deviation": (0.1, 0.0)},
        {"on_rate_limit": "deviate", "deviation": (np.nan, 1.0)},
        {"on_rate_limit": "deviate", "deviation": 0.1},
    ],
)
def test_bad_options_are_refused(options):
    arm, posture, motion = past_the_shoulder()
    refused(r"on_rate_limit|deviation", arm.follow, motion, q0=posture, **options)


def test_a_joint_that_must_not_move_is_named():
    limits = UR3.limits
    velocity = limits.velocity.copy()
    velocity[2] = 0.0
    stiff = lt.arm.JointLimits(limits.joint_names, limits.lower, limits.upper, velocity)
    arm = lt.Arm(UR3.document, UR3.base, UR3.tip, stiff)
    _, posture, motion = past_the_wrist(0.5, 0.2)
    with pytest.raises(LimitsInfeasible, match="elbow_joint"):
        arm.follow(motion, q0=posture, on_rate_limit="slow")


def test_a_mirrored_path_is_lagged_behind_and_caught_up_with_alike():
    posture = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.0])
    times = np.linspace(0.0, 0.8, 161)
    s = np.minimum(times / 0.35, 1.0)
    along = 0.3 * minimum_jerk(s)

    def followed(side):
        positions = PANDA.forward_kinematics(posture)[0] + np.outer(side * along, [0.0, 1.0, 0.0])
        motion = lt.Trajectory(times, positions)
        return PANDA.follow(
            motion, q0=posture, on_rate_limit="deviate", deviation=(0.2, 1.0)
        ).positions

    np.testing.assert_allclose(followed(1.0) * [-1, 1, -1, 1, -1, 1, 1], followed(-1.0), atol=1e-6)
