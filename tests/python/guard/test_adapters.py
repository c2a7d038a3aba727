"""A guard between messages of ROS 2, and in a pipeline of LeRobot."""

import subprocess
import sys

import numpy as np
import pytest
from guard.adversary import HOMES
from refusals import refused
from rosbags.typesys import Stores, get_typestore

import leadthrough as lt
from leadthrough.guard.lerobot import GuardStep
from leadthrough.guard.ros import admit_message, message_of, trajectory_of

Q = HOMES["panda"]
TIMES = 0.02 * np.arange(1, 51)
ROWS = Q + 0.1 * np.outer(1.0 - np.cos(np.pi * TIMES), np.linspace(0.2, 1.0, 7))


@pytest.fixture
def guard(panda):
    return lt.Guard(panda, rate=50.0)


def test_a_message_that_is_allowed_comes_back_with_a_way_to_rest(panda, guard):
    sent = message_of(lt.JointTrajectory(TIMES[:40], ROWS[:40], joint_names=panda.joint_names))
    received, answer = admit_message(guard, sent, Q)
    assert answer.verdict == "allowed"
    motion = trajectory_of(received)
    assert motion.joint_names == panda.joint_names
    assert np.array_equal(motion.positions[:40], ROWS[:40])
    assert np.array_equal(motion.positions[40:], answer.brake.positions)
    assert np.allclose(motion.times, 0.02 * np.arange(1, len(motion) + 1))


def test_messages_can_be_serialised(panda, guard):
    types = get_typestore(Stores.ROS2_HUMBLE)
    fast = lt.JointTrajectory(TIMES, Q + 12.0 * (ROWS - Q), joint_names=panda.joint_names)
    received, answer = admit_message(guard, message_of(fast), Q)
    assert answer.verdict == "changed"
    kind = "trajectory_msgs/msg/JointTrajectory"
    back = types.deserialize_cdr(types.serialize_cdr(received, kind), kind)
    assert np.array_equal(trajectory_of(back).positions, answer.to_rest.positions)


def test_joints_of_a_message_are_found_by_name(panda, guard):
    turned = lt.JointTrajectory(TIMES, ROWS[:, ::-1], joint_names=panda.joint_names[::-1])
    _, answer = admit_message(guard, message_of(turned), Q)
    assert np.array_equal(answer.motion.positions, ROWS)


def test_a_message_without_points_is_refused(panda, guard):
    sent = message_of(lt.JointTrajectory([0.0], Q[None], joint_names=panda.joint_names))
    sent.points.clear()
    refused("message: expected at least one point", admit_message, guard, sent, Q)


def action(panda, q):
    return {f"{name}.pos": x for name, x in zip(panda.joint_names, np.degrees(q), strict=True)}


def test_actions_in_degrees_pass_and_jumps_do_not(panda, guard):
    step = GuardStep(guard)
    sent = {"observation": action(panda, Q), "action": {**action(panda, ROWS[0]), "gripper.pos": 3}}
    out = step(sent)
    assert out["action"]["gripper.pos"] == 3
    assert step.answer.verdict == "allowed"
    assert out["action"] == pytest.approx(sent["action"], abs=1e-12)
    jumped = step({"action": action(panda, ROWS[0] + 1.0)})
    assert step.answer.verdict == "changed"
    moved = np.array(list(jumped["action"].values())) - list(action(panda, ROWS[0]).values())
    assert np.abs(np.radians(moved)).max() < panda.limits.acceleration.max() * 0.02**2 * 1.01


def test_an_action_that_is_not_finite_brakes(panda, guard):
    step = GuardStep(guard, unit="radians")
    for q in ROWS[:10]:
        names = [f"{name}.pos" for name in panda.joint_names]
        at = dict(zip(names, q, strict=True))
        step({"observation": dict(zip(names, Q, strict=True)), "action": at})
    step({"action": {**at, names[2]: float("nan")}})
    assert (step.answer.verdict, step.answer.safe) == ("braking", True)


def test_a_new_episode_begins_where_the_arm_is_observed(panda, guard):
    step = GuardStep(guard)
    step({"observation": action(panda, Q), "action": action(panda, Q)})
    step.reset()
    out = step({"observation": action(panda, Q + 0.5), "action": action(panda, Q + 0.5)})
    assert out["action"] == pytest.approx(action(panda, Q + 0.5), abs=1e-12)
    assert step.transform_features({"a": 1}) == {"a": 1}
    assert step.get_config() == {"unit": "degrees", "rate": pytest.approx(50.0)}
    step.load_state_dict(step.state_dict())


def test_what_is_missing_is_named(panda, guard):
    step = GuardStep(guard)
    refused(r"action: expected a mapping with 'panda_joint1.pos'", step, {"action": [1.0]})
    refused("observation: expected a mapping", step, {"action": action(panda, Q)})
    refused(r"action: expected 'panda_joint1.pos', got gripper", step, {"action": {"gripper": 1.0}})


def test_the_steps_count_as_those_of_a_lerobot_that_is_installed(tmp_path):
    """Its pipelines check each step's class; here it is a package with that class alone."""
    package = tmp_path / "lerobot" / "processor"
    package.mkdir(parents=True)
    for folder in (package.parent, package):
        (folder / "__init__.py").touch()
    (package / "pipeline.py").write_text("import abc\nclass ProcessorStep(abc.ABC):\n    pass\n")
    program = (
        "from lerobot.processor.pipeline import ProcessorStep\n"
        "from leadthrough.guard.lerobot import ChunkStep, GuardStep\n"
        "assert issubclass(GuardStep, ProcessorStep) and issubclass(ChunkStep, ProcessorStep)\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True)
