"""Leading an arm by its tip, recordings of it, and what is learned from them, without a browser."""

import json
import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.show.lesson import learned
from leadthrough.show.recordings import Recordings, recording_of
from leadthrough.show.teaching import LedArm, Teaching, first_configuration

STEP = 0.02
POST = lt.Box((0.1, 0.1, 0.5), (0.5, 0.3, 0.25))


@pytest.fixture
def teaching(panda, tmp_path):
    session = Teaching(panda, lt.Scene([POST]), Recordings(panda, tmp_path / "recorded", ()))
    yield session
    session.close()


def said(session, action, **parts):
    session.hear(json.dumps({"do": action, **parts}))
    return advanced(session)


def advanced(session, steps=1):
    return [json.loads(each) for _ in range(steps) for each in session.advance(STEP)]


def state_of(messages):
    return [each for each in messages if each["kind"] == "state"][-1]


def led(session, *offsets, steps=60):
    """Leads the tip through offsets from where it is."""
    for offset in offsets:
        position = session.led.tip[0] + offset
        said(session, "lead", position=position.tolist())
        advanced(session, steps)
    said(session, "release")


def demonstrated(session, sideways=0.0):
    """Records an arch from the same start."""
    start = session.led.q
    said(session, "record")
    led(session, (0.0, -0.08 - sideways, -0.05), (0.05, -0.08, 0.02))
    told = state_of(said(session, "stop"))
    session.led.put(start)
    return told


def planned(session):
    """The state after all that is asked for has been answered."""
    told = []
    for _ in range(3000):
        told += advanced(session)
        if session.idle:
            return state_of(told)
        time.sleep(0.01)
    raise AssertionError("nothing was planned")


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_the_first_configuration_is_clear_and_the_tip_can_move_all_ways(name):
    arm = lt.Arm.load(name)
    q = first_configuration(arm, lt.Scene())
    assert arm.is_clear(q)
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        led_arm = LedArm(arm, lt.Scene())
        before = led_arm.tip[0]
        led_arm.lead(before + 0.03 * axis)
        for _ in range(60):
            led_arm.advance(STEP)
        np.testing.assert_allclose(led_arm.tip[0], before + 0.03 * axis, atol=1e-3)


def test_the_led_arm_keeps_limits_speeds_and_its_distance_from_everything(panda):
    scene = lt.Scene([POST])
    led_arm, rng = LedArm(panda, scene), np.random.default_rng(3)
    rows = [led_arm.q]
    for _ in range(40):  # anywhere, also through the post and out of reach
        led_arm.lead(rng.uniform([-0.2, -0.6, -0.1], [0.9, 0.6, 0.9]))
        led_arm.turn(rng.normal(0.0, 0.3, 3))
        for _ in range(15):
            led_arm.advance(STEP)
            rows.append(led_arm.q)
    q = np.array(rows)
    assert (q >= panda.limits.lower).all()
    assert (q <= panda.limits.upper).all()
    assert (np.abs(np.diff(q, axis=0)) / STEP <= panda.limits.velocity).all()
    motion = lt.JointTrajectory(STEP * np.arange(len(q)), q, joint_names=panda.joint_names)
    assert panda.check(motion, scene).ok
    assert np.ptp(panda.forward_kinematics(q)[0], axis=0).min() > 0.3  # and it went about


def test_the_tip_slides_along_a_post_and_says_what_is_in_the_way(panda):
    led_arm = LedArm(panda, lt.Scene([lt.Box((2.0, 0.1, 2.0), (0.5, 0.35, 0.0))]))  # a wall
    before = led_arm.tip[0]
    led_arm.lead(before + np.array([0.0, 0.4, -0.1]))
    reasons = set()
    for _ in range(100):
        led_arm.advance(STEP)
        reasons.add(led_arm.blocked)
    assert led_arm.tip[0][1] < before[1] + 0.3
    assert led_arm.tip[0][2] == pytest.approx(before[2] - 0.1, abs=2e-3)
    assert "an obstacle or the arm itself is in the way" in reasons


def test_the_tool_turns_by_what_was_asked_for(panda):
    led_arm = LedArm(panda, lt.Scene())
    before = led_arm.tip
    led_arm.turn(np.array([0.0, 0.0, 0.4]))
    for _ in range(80):
        led_arm.advance(STEP)
    position, orientation = led_arm.tip
    turned = lt.rotations.compose(lt.rotations.exp([[0.0, 0.0, 0.4]]), before[1][None])
    assert lt.rotations.distance(orientation[None], turned)[0] < 1e-3
    np.testing.assert_allclose(position, before[0], atol=1e-4)


def test_a_demonstration_is_in_its_file_when_stop_is_pressed(teaching, panda):
    start = teaching.led.tip[0]
    told = demonstrated(teaching)
    (shown,) = told["demonstrations"]
    (path,) = teaching.recordings.folder.glob("*.csv")
    assert path.stem == shown["name"] == "demonstration-1"
    motion = lt.read_motion(path)
    assert motion.joint_names == panda.joint_names
    tips = panda.forward_kinematics(motion.positions)[0]
    np.testing.assert_allclose(tips[0], start, atol=2e-3)
    np.testing.assert_allclose(tips[-1], start + np.array([0.05, -0.16, -0.03]), atol=3e-3)
    assert shown["seconds"] == pytest.approx(motion.duration, abs=0.01)
    assert told["command"].startswith("leadthrough learn ")


def test_rest_before_and_after_is_left_out_and_events_stay_where_they_happened(teaching):
    said(teaching, "record")
    advanced(teaching, 50)
    led(teaching, (0.0, -0.1, 0.0))
    said(teaching, "gripper")
    led(teaching, (0.0, 0.0, -0.1))
    advanced(teaching, 100)
    said(teaching, "stop")
    motion = teaching.recordings.demonstrations[0].motion
    assert 1.5 < motion.duration < 2.6  # of 5.4 s
    (event,) = motion.events
    assert event.name == "close gripper"
    np.testing.assert_allclose(
        teaching.arm.forward_kinematics(motion.at(event.time))[0],
        teaching.arm.forward_kinematics(motion.positions[0])[0] + [0.0, -0.1, 0.0],
        atol=3e-3,
    )


def test_a_recording_without_a_motion_is_none(teaching, panda):
    said(teaching, "record")
    told = state_of(said(teaching, "stop"))
    assert "did not move" in told["text"]
    assert not teaching.recordings.folder.exists()
    assert recording_of(panda, [(0.1 * i, teaching.led.q) for i in range(50)], []) is None


def test_a_page_that_is_closed_while_it_records_keeps_the_recording(teaching):
    said(teaching, "record")
    led(teaching, (0.0, -0.1, 0.0))
    teaching.left()
    assert [path.name for path in teaching.recordings.folder.glob("*")] == ["demonstration-1.csv"]


def test_a_recording_that_cannot_be_written_goes_on_until_it_can(teaching):
    said(teaching, "record")
    led(teaching, (0.0, -0.1, 0.0))
    in_the_way = teaching.recordings.folder
    in_the_way.write_text("")
    told = state_of(said(teaching, "stop"))
    assert "exists" in told["text"]
    assert told["recording"]
    teaching.left()
    in_the_way.unlink()
    assert not state_of(said(teaching, "stop"))["recording"]
    assert [path.name for path in in_the_way.glob("*")] == ["demonstration-1.csv"]


def test_trouble_with_what_was_learned_is_told_and_the_page_goes_on(teaching):
    demonstrated(teaching)
    said(teaching, "learn")
    teaching.skill_path.mkdir()
    while teaching._lesson is not None:
        told = advanced(teaching)
    assert "skill.npz" in state_of(told)["text"]
    assert teaching.planner is not None


def test_a_deleted_demonstration_is_gone_and_its_number_is_not_given_again(teaching):
    for _ in range(2):
        demonstrated(teaching)
    told = state_of(said(teaching, "delete", index=0))
    assert [each["name"] for each in told["demonstrations"]] == ["demonstration-2"]
    assert [each["name"] for each in demonstrated(teaching)["demonstrations"]] == [
        "demonstration-2",
        "demonstration-3",
    ]


def files(session):
    return sorted(path.stem for path in session.recordings.folder.glob("*"))


def recorded(session, name):
    return lt.read_motion(session.recordings.folder / f"{name}.csv")


def test_a_new_name_is_that_of_the_file_at_once_and_can_be_taken_back(teaching):
    for _ in range(2):
        demonstrated(teaching)
    before = (teaching.recordings.folder / "demonstration-1.csv").read_bytes()
    told = state_of(said(teaching, "rename", index=0, name=" over the post "))
    assert [each["name"] for each in told["demonstrations"]] == ["over the post", "demonstration-2"]
    assert files(teaching) == ["demonstration-2", "over the post"]
    assert (teaching.recordings.folder / "over the post.csv").read_bytes() == before
    told = state_of(said(teaching, "restore"))
    assert told["demonstrations"][0]["name"] == "demonstration-1"
    assert files(teaching) == ["demonstration-1", "demonstration-2"]
    assert (teaching.recordings.folder / "demonstration-1.csv").read_bytes() == before


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        "../away",
        "a/b",
        "a\\b",
        ".hidden",
        "a\nb",
        "x" * 81,
        "demonstration-2",
        "Notes",
        3,
        None,
    ],
)
def test_names_that_no_file_can_have_or_another_has_change_nothing(teaching, name):
    for _ in range(2):
        demonstrated(teaching)
    (teaching.recordings.folder / "notes.csv").write_text("of somebody else\n")
    told = state_of(said(teaching, "rename", index=0, name=name))
    assert told["text"].startswith("name: ")
    assert [each["name"] for each in told["demonstrations"]] == [
        "demonstration-1", "demonstration-2",
    ]  # fmt: skip
    assert files(teaching) == ["demonstration-1", "demonstration-2", "notes"]


def test_a_motion_is_cut_at_the_times_chosen_and_so_is_its_file(teaching):
    said(teaching, "record")
    led(teaching, (0.0, -0.08, 0.0))
    said(teaching, "gripper")
    led(teaching, (0.0, -0.08, 0.0), steps=80)
    said(teaching, "gripper")
    led(teaching, (0.0, -0.08, 0.0))
    said(teaching, "stop")
    whole = recorded(teaching, "demonstration-1")
    closed, opened = (event.time for event in whole.events)
    first, last = closed + 0.05, opened - 0.17
    said(teaching, "trim", index=0, last=last)
    told = state_of(said(teaching, "trim", index=0, first=first))
    cut = recorded(teaching, "demonstration-1")
    assert cut.times[0] == 0.0
    assert cut.duration == pytest.approx(last - first, abs=1e-4)
    for part in (0.0, 0.4, 1.0):
        np.testing.assert_allclose(
            cut.at(part * cut.duration), whole.at(first + part * (last - first)), atol=2e-4
        )
    assert told["demonstrations"][0]["seconds"] == pytest.approx(cut.duration, abs=0.01)
    assert told["shown"] == [0]
    # The gripper is closed where the motion begins now; it opens after its end.
    assert [(event.time, event.name) for event in cut.events] == [(0.0, "close gripper")]
    np.testing.assert_allclose(teaching.motion.positions, cut.positions, atol=1e-9)
    said(teaching, "restore")
    back = recorded(teaching, "demonstration-1")
    np.testing.assert_allclose(back.positions[0], whole.positions[0])
    assert back.duration == pytest.approx(last, abs=1e-4)


def test_trimming_that_leaves_no_motion_changes_nothing(teaching):
    demonstrated(teaching)
    before = (teaching.recordings.folder / "demonstration-1.csv").read_bytes()
    for wrong in (
        {"last": 0.02}, {"first": 2.0, "last": 1.0}, {"first": -1.0}, {"last": 1e9}, {"first": "x"},
    ):  # fmt: skip
        told = state_of(said(teaching, "trim", index=0, **wrong))
        assert re.match("first|last|motion", told["text"]), told["text"]
        assert told["demonstrations"][0]["seconds"] > 1.0
    assert (teaching.recordings.folder / "demonstration-1.csv").read_bytes() == before


def test_a_deleted_demonstration_comes_back_to_its_file(teaching):
    for _ in range(2):
        demonstrated(teaching)
    before = (teaching.recordings.folder / "demonstration-1.csv").read_bytes()
    assert state_of(said(teaching, "delete", index=0))["restorable"]
    told = state_of(said(teaching, "restore"))
    assert [each["name"] for each in told["demonstrations"]] == [
        "demonstration-1", "demonstration-2",
    ]  # fmt: skip
    assert not told["restorable"]
    assert (teaching.recordings.folder / "demonstration-1.csv").read_bytes() == before


def test_agreement_with_the_others_is_that_of_the_judgement_of_the_tips_motions(teaching, panda):
    assert state_of([json.loads(teaching.greeting()[-1])])["demonstrations"] == []
    told = demonstrated(teaching)
    assert told["demonstrations"][0]["differs"] is None
    for sideways in (0.0, 0.005, 0.01):
        demonstrated(teaching, sideways)
    said(teaching, "record")  # from the same start to the same end, but far up in between
    led(teaching, (0.0, -0.05, 0.25), (0.05, -0.11, -0.28))
    (*_, odd) = shown = state_of(said(teaching, "stop"))["demonstrations"]
    judged = lt.judge_demonstrations(
        [lt.Demonstration(panda.poses(each.motion)) for each in teaching.demonstrations]
    )
    assert [each["differs"] for each in shown] == pytest.approx(
        [each.suspicion for each in judged.verdicts], abs=0.051
    )
    assert [tuple(each["faults"]) for each in shown] == [each.faults for each in judged.verdicts]
    assert odd["faults"][0] == "outlier"
    assert max(each["differs"] for each in shown[:-1]) < 3.0


def test_learned_moved_corrected_undone_and_saved(teaching, panda):
    for sideways in (0.0, 0.01):
        demonstrated(teaching, sideways)
    said(teaching, "learn")
    told = planned(teaching)
    assert told["learned"]
    assert "within" in told["text"]
    goal = np.array(told["goal"])
    first = teaching.motion
    said(teaching, "goal", position=(goal + np.array([0.03, 0.0, 0.04])).tolist())
    assert f"--goal={goal[0] + 0.03:.5g}"[:10] in planned(teaching)["command"]
    tips = panda.forward_kinematics(teaching.motion.positions)[0]
    np.testing.assert_allclose(tips[-1], goal + np.array([0.03, 0.0, 0.04]), atol=1e-3)
    middle = 0.5 * teaching.motion.duration
    wanted = panda.forward_kinematics(teaching.motion.at(middle))[0] + [0.0, 0.0, 0.03]
    said(teaching, "correct", time=middle, position=wanted.tolist())
    said(teaching, "save")  # while it plans, whose verdict must not hide where the skill is
    told = planned(teaching)
    assert told["corrections"] == 1
    assert told["text"].startswith("The skill is in")
    np.testing.assert_allclose(
        panda.forward_kinematics(teaching.motion.at(middle))[0], wanted, atol=3e-3
    )
    np.testing.assert_allclose(teaching.planner.via, [wanted], atol=3e-3)
    assert [each.layer for each in teaching.drawn._whole().items][-2:] == ["goal", "via points"]
    assert panda.check(teaching.motion, teaching.led.scene).ok
    assert "<title>panda</title>" in teaching.skill_path.with_suffix(".html").read_text()
    saved = lt.load_skill(teaching.skill_path)
    assert len(saved.corrections) == 1
    said(teaching, "undo")
    assert planned(teaching)["corrections"] == 0
    teaching.skill_path.unlink()
    teaching.hear(json.dumps({"do": "goal", "position": goal.tolist()}))
    teaching.hear(json.dumps({"do": "save"}))
    teaching.close()
    assert not lt.load_skill(teaching.skill_path).corrections
    assert first.joint_names == teaching.motion.joint_names


def test_a_taught_set_is_saved_for_lerobot_and_its_command_names_it(teaching, panda):
    assert "first" in state_of(said(teaching, "export"))["text"]
    for sideways in (0.0, 0.01):
        demonstrated(teaching, sideways)
    for name in ("recorded-lerobot", "recorded-lerobot-2"):
        folder = teaching.recordings.folder.with_name(name)
        told = state_of(said(teaching, "export"))
        assert told["command"] == f"leadthrough learn {folder} -o skill.npz"
        back = lt.read_demonstrations(folder, rest=math.inf)
        assert len(back) == 2
        for ours, given in zip(back, teaching.demonstrations, strict=True):
            np.testing.assert_allclose(
                ours.motion.positions[[0, -1]], given.motion.positions[[0, -1]], atol=1e-4
            )
    assert demonstrated(teaching)["command"].endswith("recorded -o skill.npz")


def test_an_obstacle_is_not_moved_into_the_arm(teaching):
    told = said(teaching, "obstacle", index=0, position=teaching.led.tip[0].tolist())
    assert "lead it away" in state_of(told)["text"]
    assert teaching.led.scene.shapes[0].position.tolist() == [0.5, 0.3, 0.25]
    moved = said(teaching, "obstacle", index=0, position=[0.5, 0.45, 0.25])
    assert [each["kind"] for each in moved] == ["scene"]
    assert teaching.led.scene.shapes[0].position[1] == 0.45


@pytest.mark.parametrize(
    "message",
    [
        "", "{", "[]", "3", "null", '{"do": 3}', '{"do": "shutdown"}', '{"do": "lead"}',
        '{"do": "lead", "position": [1, 2]}', '{"do": "lead", "position": [NaN, 0, 0]}',
        '{"do": "lead", "position": "here"}', '{"do": "goal", "position": {"a": 1}}',
        '{"do": "delete", "index": 7}', '{"do": "play", "index": true}',
        '{"do": "obstacle", "index": -1, "position": [0, 0, 0]}', '{"do": "correct", "time": "x"}',
        '{"do": "rename", "index": 0, "name": "a"}', '{"do": "trim", "index": 0, "first": 1}',
        '{"do": "restore"}', '{"do": "export"}',
        '{"do": "turn", "vector": [1e999, 0, 0]}', '{"do": "undo"}', '{"do": "save"}', "[" * 5000,
    ],
)  # fmt: skip
def test_malformed_messages_change_nothing(teaching, message):
    q = teaching.led.q
    teaching.hear(message)
    told = advanced(teaching, 5)
    assert all(each["kind"] == "state" for each in told)
    assert teaching.led.q is q
    assert not teaching.recordings.demonstrations
    assert list(Path(teaching.recordings.folder.parent).iterdir()) == []


def test_a_demonstration_that_contradicts_the_others_is_named_with_what_the_page_can_do(panda):
    turns = np.linspace(0.0, 1.0, 60)[:, None]
    home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    rows = [home + turns * [0.6 + 0.02 * k, 0.3, 0.0, 0.2, 0.0, 0.0, 0.0] for k in range(3)]
    rows.append(rows[0][::-1])
    shown = [
        lt.Demonstration(lt.JointTrajectory(turns[:, 0], q, joint_names=panda.joint_names), name)
        for q, name in zip(rows, ("one", "two", "three", "back"), strict=True)
    ]
    refused("back: .*; delete it, or trim it", learned, panda, shown, lt.Scene())
    assert "within" in learned(panda, shown[:3], lt.Scene()).text
