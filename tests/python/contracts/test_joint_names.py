"""Names of joints travel with their columns: another order is permuted, other names are refused.

The table below names every public function that takes motions; the walk over the reference finds
one that is missing.
"""

import inspect
import re
from fnmatch import fnmatch
from pathlib import Path

import h5py
import numpy as np
import pytest
from cli.command_line import facts, run
from contracts.public import public_callables
from kinds import kind
from motions import arm, minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough import models, preprocess
from leadthrough.arm import FollowOptions
from leadthrough.augmentation import write_data_set
from leadthrough.errors import InvalidInput
from leadthrough.guard.ros import message_of, trajectory_of
from leadthrough.simulation import simulate_held

ARM = arm("ur3")
PAIR = lt.DualArm(ARM, arm("panda"), ((0.0, -0.9, 0.0), (1.0, 0.0, 0.0, 0.0)))
HELD = lt.arm.HeldObject(PAIR, 2 * (((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),))
PANDA_REST = [0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.8]
NAMES = ARM.joint_names
FOREIGN = tuple("abcdef")
TIMES = np.linspace(0.0, 2.0, 41)
REST = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])
MOVED = np.array([0.6, 0.2, -0.3, 0.25, 0.15, 0.8])
# One sample is worth all orders; the motion's columns differ, so that any exchange is noticed.
ORDERS = [np.random.default_rng(4).permutation(6) for _ in range(3)] + [np.arange(6)[::-1]]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files are written in a folder of the test's own."""
    monkeypatch.chdir(tmp_path)


def motion(scale=1.0):
    q = REST + np.outer(minimum_jerk(TIMES / 2.0), scale * MOVED)
    return lt.JointTrajectory(TIMES, q, joint_names=NAMES)


def reordered(joints, order):
    """The same motion with its columns, and their names, in another order."""
    names = tuple(np.array(joints.joint_names)[order].tolist())
    return lt.JointTrajectory(joints.times, joints.positions[:, order], joint_names=names)


def renamed(joints, names=FOREIGN):
    return lt.JointTrajectory(joints.times, joints.positions, joint_names=names)


MOTION = motion()
TIP = ARM.poses(MOTION)
BOX = lt.Box((0.2, 0.2, 0.2), (0.35, 0.35, 0.4))


def beside(joints):
    """The tip's motion with joints that go along."""
    return lt.PoseTrajectory(TIP.times, TIP.positions, TIP.orientations, (), joints)


class OfJoints:
    """A skill that moves the arm's joints, as somebody else's may."""

    supports = frozenset()
    kind = "theirs"

    def __init__(self, joints):
        self.joints = joints

    def generate(self, **_):
        return self.joints


def report(joints):
    found = lt.check_limits(joints, ARM.limits)
    return [found.velocity.ratios, found.position.ratios]


def checked(joints):
    found = ARM.check(joints, [BOX])
    return [found.obstacles.minimum_distance, found.itself.minimum_distance]


def paired(joints):
    """The motion of the left arm of a pair, whose right arm rests."""
    rows = np.hstack([joints.positions, np.tile(PANDA_REST, (len(joints), 1))])
    names = joints.joint_names and joints.joint_names + PAIR.right.joint_names
    return lt.JointTrajectory(joints.times, rows, joint_names=names)


def checked_pair(joints):
    found = PAIR.check(paired(joints), [BOX])
    return [found.obstacles.minimum_distance, found.itself.minimum_distance]


def carried(joints):
    relative = PAIR.relative_pose(paired(MOTION).positions[0])
    grasps = (((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)), relative)
    pair = PAIR.with_object(lt.Box((0.1, 0.1, 0.1), (0.0, 0.0, 0.1)), grasps, mass=1.0)
    found = simulate_held(lt.arm.HeldObject(pair, grasps), paired(joints), rate=100.0)
    return PAIR.motions(found.planned)[0]


def coordinated(joints):
    rest = np.tile(PANDA_REST, (len(joints), 1))
    right = lt.JointTrajectory(joints.times, rest, joint_names=PAIR.right.joint_names)
    return lt.arm.coordinate(PAIR, joints, right).joints


def followed(posture):
    options = FollowOptions(posture=posture, nullspace_gain=0.5, free=("rz",))
    return ARM.follow(TIP, q0=REST, options=options)


def pictured(joints):
    page = Path("page.html")
    lt.show.view(ARM, joints, demonstrations=[lt.Demonstration(joints)], html=page)
    return [np.frombuffer(page.read_bytes(), dtype=np.uint8)]


def embedded(joints):
    shown = lt.show.inline(ARM, joints, demonstrations=[lt.Demonstration(joints)])
    return [np.frombuffer(shown._repr_html_().encode(), dtype=np.uint8)]


def in_a_data_set(joints):
    Path("set.hdf5").unlink(missing_ok=True)
    written = write_data_set([lt.Demonstration(joints)], ARM, "set.hdf5")
    with h5py.File(written) as file:
        return [np.array(file["data/demo_0/obs/robot0_joint_pos"])]


def taught(joints):
    page = lt.show.teach(ARM, demonstrations=[lt.Demonstration(joints)])
    page.close()
    return [page.session.recordings.demonstrations[0].motion.positions]


def played(joints):
    """A motion four times as slow, whose first commands leave room to change the speed."""
    slow = lt.JointTrajectory(4 * joints.times, joints.positions, joint_names=joints.joint_names)
    play = lt.guard.Playback(slow, ARM.limits, rate=20.0)
    return [play.next() for _ in range(40)]


# One motion of an arm's joints, and numbers that must be the same in whatever order they came.
ENTRIES = {
    "arm.Arm.check": checked,
    "arm.Arm.is_clear": lambda joints: [ARM.is_clear(joints, [BOX])],
    "arm.Arm.joints_of": ARM.joints_of,
    "arm.Arm.poses": lambda joints: [ARM.poses(joints).positions],
    "arm.Arm.path_report": lambda joints: [ARM.path_report(joints, TIP).position_error],
    "arm.DualArm.check": checked_pair,
    "arm.DualArm.is_clear": lambda joints: [PAIR.is_clear(paired(joints), [BOX])],
    "arm.HeldObject.check": lambda joints: [
        len(HELD.check(paired(joints), [BOX]).itself.distances)
    ],
    "arm.HeldObject.is_clear": lambda joints: [HELD.is_clear(paired(joints), [BOX])],
    "arm.HeldObject.poses": lambda joints: [HELD.poses(paired(joints)).positions],
    "arm.DualArm.joints_of": lambda joints: PAIR.motions(PAIR.joints_of(paired(joints)))[0],
    "arm.DualArm.demonstration": lambda joints: [
        PAIR.demonstration(paired(joints)).right.positions,
        PAIR.demonstration(paired(joints)).left.positions,
    ],
    "arm.coordinate": lambda joints: PAIR.motions(coordinated(joints))[0],
    "arm.DualArm.motions": lambda joints: PAIR.motions(paired(joints))[0],
    "arm.FollowOptions": followed,
    "augmentation.write_data_set": in_a_data_set,
    "guard.Guard.admit": lambda joints: lt.Guard(ARM, rate=100.0).admit(joints, REST).motion,
    "guard.Playback": played,
    "guard.connect": lambda joints: lt.connect(REST, joints, ARM),
    "motion_planning.plan_motion": lambda joints: lt.plan_motion(OfJoints(joints), ARM).joints,
    "show.inline": embedded,
    "show.teach": taught,
    "show.view": pictured,
    "simulation.simulate_held": carried,
    "simulation.simulate": lambda joints: lt.simulate(ARM, joints, rate=100.0).planned,
    "timing.binding_limits": lambda joints: [
        [each.ratio for each in lt.timing.binding_limits(joints, ARM.limits)]
    ],
    "timing.check_limits": report,
    "timing.keep_timing": lambda joints: lt.keep_timing(joints, ARM.limits, rate=100.0),
    "timing.retime": lambda joints: lt.retime(joints, ARM.limits, rate=100.0),
}


def fitted(family, **settings):
    def generated(one, other):
        return kind(family, **settings).build().fit([one, other]).generate(dt=0.05)

    return generated


def seen_by(method):
    def told(one, other):
        skill = lt.ProMP(weights=5).fit([MOTION, motion(0.9)])
        return [method(skill, other)]

    return told


def interpolated(one, other):
    library = lt.SkillLibrary()
    for target, each in enumerate((one, other)):
        skill = lt.DMP(weights=10).fit([each])
        library = library.with_skill(skill, task="t", subtask="s", target=[float(target)])
    return library.interpolated("t", "s", [0.4]).generate(dt=0.05)


def judged(one, other):
    found = lt.judge_demonstrations([one, motion(0.9), other, motion(0.95)])
    return [[each.worth for each in found.verdicts]]


def inferred(one, other):
    skills = [lt.ProMP(weights=5).fit([MOTION, motion(scale)]) for scale in (0.9, 0.5)]
    return [models.infer(other[:20], skills).probabilities]


def reproduced(one, other):
    """The motion that a skill of both reproduces the second one by."""
    found = models.reproduction(lt.DMP(weights=10).fit([one]), [one, other])
    return [found.positions]


# Two motions of which the second one's columns come in any order, and the first one's count.
TOGETHER = {
    "demonstration_quality.judge_demonstrations": judged,
    "models.AlignedMean.fit": fitted("AlignedMean"),
    "models.CLFDM.fit": fitted("CLFDM", components=2, quadratics=1),
    "models.DMP.fit": fitted("DMP", weights=10),
    "models.GMR.fit": fitted("GMR", components=3),
    "models.GMRSkill.updated": lambda one, other: (
        lt.GMR(components=3).fit([one]).updated([other]).generate(dt=0.05)
    ),
    "models.LPVDS.fit": fitted("LPVDS", components=2),
    "models.ProMP.fit": fitted("ProMP", weights=5),
    "models.ProMPSkill.log_likelihood": seen_by(models.ProMPSkill.log_likelihood),
    "models.RhythmicDMP.fit": fitted("RhythmicDMP", weights=10),
    "models.SEDS.fit": fitted("SEDS", components=2, objective="mse"),
    "models.SkillLibrary.with_skill": interpolated,
    "models.TaskGMR.fit": fitted("TaskGMR", components=3),
    "models.infer": inferred,
    "models.learn": lambda one, other: models.learn([one, other]).generate(dt=0.05),
    "models.reproduction": reproduced,
    "preprocess.align_by_arc_length": lambda *two: preprocess.align_by_arc_length(two)[1].motion,
    "preprocess.align_by_time_warping": lambda *two: (
        preprocess.align_by_time_warping(two)[1].motion
    ),
    "preprocess.join": lambda one, other: preprocess.join([ends_swapped(one), other]),
}


def ends_swapped(joints):
    names = joints.joint_names
    return lt.JointTrajectory(joints.times, joints.positions[::-1], joint_names=names)


def through(format):
    def read_back(joints):
        lt.write_motion(joints, Path(f"motion.{format}"))
        return lt.read_motion(Path(f"motion.{format}"))

    return read_back


def distributed(motions, limit=None):
    """A ProMP of joints, with limits that differ."""
    skill = lt.ProMP(weights=5).fit(motions)
    return skill if limit is None else skill.within(np.full(6, -np.inf), limit)


def foreseen(*two):
    found = models.infer(MOTION[:20], two)
    return [found.probabilities, found.skills[1].free.covariance, found.skills[1].bounds]


# Two skills of which the second one's columns come in any order, and the first one's count.
OF_SKILLS = {
    "models.combine": lambda *two: [models.combine(two).weights.mean],
    "models.blend": lambda *two: models.blend(two, TIMES, np.ones((len(TIMES), 2))),
    "models.infer": foreseen,
}


# One motion that comes back, with its names on the columns that they came with.
KEEPING = {
    "Demonstration": lambda joints: lt.Demonstration(beside(joints)).joints,
    "PoseTrajectory": lambda joints: beside(joints).joints,
    "Trajectory": lambda joints: lt.Trajectory(TIMES, TIP.positions, joints=joints).joints,
    "guard.ros.message_of": lambda joints: trajectory_of(message_of(joints)),
    "io.write_motion": through("csv"),
    "models.DMPSkill.relearned": lambda joints: (
        lt.DMP(weights=10).fit([MOTION]).relearned(joints).generate(dt=0.05)
    ),
    "models.generate_all": lambda joints: models.generate_all(
        lt.DMP(weights=10).fit([joints]), [{"dt": 0.05}]
    )[0],
    "preprocess.clean": lambda joints: preprocess.clean(joints)[0].motion,
    "preprocess.cut_at_gaps": lambda joints: preprocess.cut_at_gaps(joints)[0].motion(),
    "preprocess.sample_evenly": lambda joints: preprocess.sample_evenly(joints, rate=10.0).motion,
    "preprocess.segment": lambda joints: preprocess.segment(joints)[0].motion,
    "preprocess.smooth_by_spline": lambda joints: preprocess.smooth_by_spline(joints).motion,
    "preprocess.smooth_motion": lambda joints: preprocess.smooth_motion(joints, window=0.3).motion,
    "preprocess.trim": lambda joints: preprocess.trim(joints).motion,
}
# Names, with * for any, of what takes no joints of an arm, or only holds what another made.
OTHERS = {
    "arm.DualArm.located": "joints as by joints_of, above",
    "models.FastMarching.fit": "points and poses",
    "models.Frame.*": "points and poses",
    "models.Framed.fit": "points and poses",
    "models.ModifiedDS.fit": "points",
    "reachability.place_base": "poses",
    "simulation.CartesianImpedance.of_skill": "points and poses",
    "models.*.parameters": "adjustments of a skill, whose fit is above",
    "models.Model.fit": "a protocol",
    "models.dynamical.model.DynamicalModel.fit": "a base class",
    "validation.validate": "plans by plan_motion",
    "augmentation.augment": "plans as validate does",
    "show.open_view": "the page of show.view",
    "arm.DualDemonstration": "holds", "arm.CoordinatedMotion": "holds",
    "models.*Skill": "holds", "models.Inference": "holds", "models.Parameter": "holds",
    "models.dynamical.model.Samples": "holds", "arm.StackRun": "holds",
    "guard.Admission": "holds", "io.Episode": "holds", "io.Recording": "holds",
    "motion_planning.PlannedMotion": "holds", "reachability.Placement": "holds",
    "simulation.SimulationReport": "holds",
    "simulation.HeldSimulation": "holds",
}  # fmt: skip
TAKES = re.compile(r"JointTrajectory|\bMotion|Demonstration|Recording|Skill|Generator\[|Posture")


def takes_motions(value):
    if not callable(value):
        return False
    try:
        parameters = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):  # of the core
        return False
    return any(TAKES.search(str(each.annotation)) for each in parameters)


def test_every_public_function_that_takes_motions_is_in_the_table():
    found = {name for name, value in public_callables() if takes_motions(value)}
    listed = [*ENTRIES, *TOGETHER, *OF_SKILLS, *KEEPING, *OTHERS]
    assert not {name for name in found if not any(fnmatch(name, each) for each in listed)}
    assert not [each for each in listed if not any(fnmatch(name, each) for name in found)]


def assert_same(one, other):
    if isinstance(one, lt.JointTrajectory):
        assert one.joint_names == other.joint_names == NAMES
        one, other = [one.times, one.positions], [other.times, other.positions]
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("name", ENTRIES)
def test_another_order_of_joints_is_permuted(name):
    expected = ENTRIES[name](MOTION)
    for order in ORDERS:
        assert_same(ENTRIES[name](reordered(MOTION, order)), expected)
    assert_same(ENTRIES[name](renamed(MOTION, ())), expected)


@pytest.mark.parametrize("name", ENTRIES)
def test_joints_of_another_arm_are_refused_with_both_lists(name):
    refused(f"{', '.join(NAMES)}.*{', '.join(FOREIGN)}", ENTRIES[name], renamed(MOTION))
    refused("wrist_3_joint", ENTRIES[name], renamed(MOTION, (*NAMES[:5], "f")))


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
@pytest.mark.parametrize("name", TOGETHER)
def test_joints_of_several_motions_are_put_in_one_order(name):
    expected = TOGETHER[name](MOTION, motion(0.8))
    for order in ORDERS[:1]:
        assert_same(TOGETHER[name](MOTION, reordered(motion(0.8), order)), expected)


@pytest.mark.parametrize("name", TOGETHER)
def test_joints_of_several_arms_are_refused_with_both_lists(name):
    with pytest.raises(InvalidInput, match=f"{', '.join(NAMES)}.*{', '.join(FOREIGN)}"):
        TOGETHER[name](MOTION, renamed(motion(0.8)))


@pytest.mark.parametrize("name", OF_SKILLS)
def test_joints_of_several_skills_are_put_in_one_order(name):
    first, others = distributed([MOTION, motion(0.9)]), [motion(0.8), motion(0.7)]
    order, limit = ORDERS[0], np.arange(3.0, 9.0) if name == "models.infer" else None
    expected = OF_SKILLS[name](first, distributed(others, limit))
    shuffled = [reordered(each, order) for each in others]
    given = OF_SKILLS[name](first, distributed(shuffled, limit if limit is None else limit[order]))
    for one, other in zip(given, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)
    with pytest.raises(InvalidInput, match=f"{', '.join(NAMES)}.*{', '.join(FOREIGN)}"):
        OF_SKILLS[name](first, distributed([renamed(each) for each in others]))


@pytest.mark.parametrize("name", KEEPING)
def test_names_stay_on_their_columns(name):
    expected = KEEPING[name](MOTION)
    for order in ORDERS[:1]:
        given = KEEPING[name](reordered(MOTION, order))
        assert given.joint_names == tuple(np.array(NAMES)[order].tolist())
        np.testing.assert_allclose(given.positions, expected.positions[:, order], atol=1e-9)


def test_joints_beside_demonstrations_of_the_tip_are_put_in_one_order():
    def posture(other):
        skill = lt.ProMP(weights=5).fit([beside(MOTION), beside(other)])
        return skill.generate(dt=0.05).joints

    assert_same(posture(reordered(motion(0.8), ORDERS[0])), posture(motion(0.8)))


def test_commands_permute_and_refuse_joints_by_their_names():
    lt.write_motion(reordered(MOTION, ORDERS[0]), Path("shuffled.csv"))
    run("retime", "shuffled.csv", "--robot", "ur3", "-o", "timed.json")
    timed = lt.read_motion(Path("timed.json"))
    assert timed.joint_names == NAMES
    np.testing.assert_allclose(timed.positions[-1], MOTION.positions[-1], atol=1e-6)
    lt.write_motion(renamed(MOTION), Path("foreign.npz"))
    for command in (("retime", "-o", "o.json"), ("check",), ("simulate",)):
        told = " ".join(
            run(command[0], "foreign.npz", "--robot", "ur3", *command[1:], code=2).stderr.split()
        )
        assert "expected the joints shoulder_pan_joint" in told
        assert "got a, b, c, d, e, f" in told


def test_columns_that_only_number_the_joints_are_in_the_arms_order():
    lt.write_motion(renamed(MOTION, ("q1", "q2", "q3", "q4", "q5", "q6")), Path("numbered.csv"))
    assert facts("check", "numbered.csv", "--robot", "ur3", code=0)
    lt.write_motion(renamed(MOTION, ("q1", "q2", "q3", "q4", "q5", "q7")), Path("mixed.npz"))
    assert (
        "or name the columns q1, q2" in run("check", "mixed.npz", "--robot", "ur3", code=2).stderr
    )
