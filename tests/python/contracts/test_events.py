"""Every stage hands events on: they stay where on the way they happened."""

import json
from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.models import TaskGMR
from leadthrough.preprocess import align_by_arc_length, align_by_time_warping, segment

CLOSED, OPENED = lt.Event(1.3, "closed"), lt.Event(2.0, "opened")
TIMES = np.linspace(0.0, 2.0, 201)
S = (TIMES / 2.0) ** 3 * (10.0 - 15.0 * TIMES / 2.0 + 6.0 * (TIMES / 2.0) ** 2)
ARM = lt.Arm.load("ur3")
START = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])


def points():
    bow = np.column_stack([0.3 * S, 0.05 * np.sin(np.pi * S), 0.1 * S])
    return lt.Trajectory(TIMES, bow, (CLOSED, OPENED))


def poses():
    turned = rotations.exp(np.outer(S, [0.0, 0.0, 2.0]))
    return lt.PoseTrajectory(TIMES, points().positions, turned, (CLOSED, OPENED))


def joints():
    q = START + np.outer(S, [0.6, 0.2, -0.3, 0.3, 0.2, 0.8])
    return lt.JointTrajectory(TIMES, q, None, None, ARM.joint_names, (CLOSED, OPENED))


def at(motion, time):
    return np.array([np.interp(time, motion.times, column) for column in motion.positions.T])


def assert_kept(made, shown, *, atol):
    """The same events, at the same places on the way."""
    assert [event.name for event in made.events] == [event.name for event in shown.events]
    for new, old in zip(made.events, shown.events, strict=True):
        np.testing.assert_allclose(at(made, new.time), at(shown, old.time), atol=atol)


@pytest.mark.parametrize(
    ("model", "shown"),
    [
        (lt.DMP(), points()),
        (lt.DMP(), joints()),
        (lt.PoseDMP(), poses()),
        (lt.ProMP(), joints()),
        (lt.ProMP(), poses()),
        (lt.ProMP(basis="bspline"), points()),
        (lt.GMR(12), points()),
        (lt.GMR(12), poses()),
        (TaskGMR(12), points()),
        (lt.FastMarching(), points()),
        (lt.FastMarching(), poses()),
        (lt.FastMarching(timing="constant"), points()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_models_generate_them_where_they_were_shown(model, shown, tmp_path):
    skill = model.fit([lt.Demonstration(shown)])
    made = skill.generate(duration=5.0)
    assert_kept(made, shown, atol=0.02)
    assert made.events[1].time == pytest.approx(5.0, abs=0.05)
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").generate(duration=5.0).events == made.events


def test_fast_marching_keeps_them_backwards_and_in_what_it_learns_itself():
    skill = lt.FastMarching().fit([lt.Demonstration(points())])
    back = skill.generate(start=(0.3, 0.0, 0.1), goal=(0.0, 0.0, 0.0))
    assert [event.name for event in back.events] == ["opened", "closed"]
    np.testing.assert_allclose(at(back, back.events[1].time), at(points(), 1.3), atol=0.01)
    line = np.linspace([0.0, 0.2, 0.0], [0.3, 0.2, 0.0], 50)
    assert skill.with_experience(line).learned[0].events == skill.demonstrated[0].events


@pytest.mark.parametrize("model", [lt.RhythmicDMP(period=2.0), lt.RhythmicPoseDMP(period=2.0)])
def test_rhythms_have_them_in_every_round(model, tmp_path):
    t = np.linspace(0.0, 4.0, 401)
    circle = 0.1 * np.column_stack([np.cos(np.pi * t), np.sin(np.pi * t), 0.0 * t])
    happened = (lt.Event(0.5, "tap"), lt.Event(2.7, "tap"))
    if isinstance(model, lt.RhythmicDMP):
        shown = lt.Trajectory(t, circle, happened)
    else:
        still = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
        shown = lt.PoseTrajectory(t, circle, still, happened)
    skill = model.fit([lt.Demonstration(shown)])
    made = skill.generate(duration=5.0, period=2.0)
    assert [event.name for event in made.events] == ["tap"] * 3
    np.testing.assert_allclose([event.time for event in made.events], [0.6, 2.6, 4.6])
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").generate().events == skill.generate().events


def test_a_rhythmic_promp_gathers_them_from_all_rounds():
    t = np.linspace(0.0, 4.0, 401)
    circle = np.column_stack([np.cos(np.pi * t), np.sin(np.pi * t)])
    shown = lt.Trajectory(t, circle, (lt.Event(0.5, "tap"), lt.Event(2.7, "tap")))
    model = lt.ProMP(basis="rhythmic", weights=12)
    skill = model.fit([lt.Demonstration(shown)], phases=[t / 2.0])
    (event,) = skill.generate(duration=1.0).events
    assert event.time == pytest.approx(0.3)


def test_libraries_interpolate_and_save_them(tmp_path):
    library = lt.SkillLibrary()
    for target, when in ((0.0, 0.8), (1.0, 1.2)):
        shown = replace(poses(), events=(lt.Event(when, "closed"),))
        skill = lt.PoseDMP().fit([lt.Demonstration(shown)])
        library = library.with_skill(skill, task="dig", subtask="reach", target=(target,))
    library.save(tmp_path / "skills.npz")
    between = lt.SkillLibrary.load(tmp_path / "skills.npz").interpolated("dig", "reach", (0.25,))
    (event,) = between.generate().events
    assert event.time == pytest.approx(0.9)


@pytest.mark.parametrize("align", [align_by_time_warping, align_by_arc_length])
def test_aligned_demonstrations_keep_them(align):
    shown = [poses(), replace(poses(), times=1.0 + 2.0 * TIMES**1.2, events=(lt.Event(3.0, "x"),))]
    for each, made in zip(shown, align([lt.Demonstration(m) for m in shown]), strict=True):
        assert_kept(made.motion, each, atol=5e-3)


def test_segments_have_those_of_their_time():
    rests = np.concatenate([np.zeros(100), S, np.ones(100), 1.0 + S, np.full(100, 2.0)])
    times = 0.01 * np.arange(len(rests))
    happened = tuple(lt.Event(time, name) for time, name in ((2.5, "a"), (3.5, "b"), (5.0, "c")))
    motion = lt.Trajectory(times, np.outer(rests, [0.3, 0.1, 0.0]), happened)
    first, second = segment(lt.Demonstration(motion))
    assert first.events == (lt.Event(2.5, "a"),)
    assert second.events == (lt.Event(5.0, "c"),)


@pytest.mark.parametrize("too_fast", ["exceed_limits", "slow"])
def test_followed_motions_keep_them(too_fast):
    position, turned = ARM.forward_kinematics(START)
    way = position + np.outer(S, [0.05, 0.1, 0.0])
    hurried = 0.1 * TIMES
    happened = (lt.Event(0.13, "closed"),)
    motion = lt.PoseTrajectory(hurried, way, np.tile(turned, (len(S), 1)), happened)
    made = ARM.follow(motion, seed=START, too_fast=too_fast)
    (event,) = made.events
    reached, _ = ARM.forward_kinematics(at(made, event.time))
    np.testing.assert_allclose(reached, at(motion, 0.13), atol=1e-4)


@pytest.mark.parametrize("timed", [lt.retime, lt.scale_to_limits])
def test_a_new_time_law_leaves_them_on_the_path(timed):
    shown = replace(joints(), times=5.0 + 0.2 * TIMES, events=(lt.Event(5.26, "closed"),))
    assert_kept(timed(shown, ARM.limits), shown, atol=1e-4)


def test_they_come_when_a_hold_begins():
    shown = replace(joints(), events=(lt.Event(float(TIMES[100]), "closed"),))
    made = lt.retime(shown, ARM.limits, holds={100: 0.5})
    (event,) = made.events
    resting = made.times[np.abs(made.velocities).max(axis=1) == 0.0]
    hold = resting[(resting > 0.0) & (resting < made.times[-1])]
    assert event.time == pytest.approx(hold[0], abs=2e-3)
    assert hold[-1] - hold[0] == pytest.approx(0.5, abs=2e-3)


def test_differentiated_and_exported_trajectories_keep_them(tmp_path):
    happened = (lt.Event(8.3, "closed"),)
    shown = lt.differentiate(replace(joints(), times=7.0 + TIMES, events=happened))
    assert shown.events == happened
    lt.io.joint_trajectory.write_json(shown, tmp_path / "arm.json")
    (event,) = json.loads((tmp_path / "arm.json").read_text())["events"]
    # The first sample is due one step, 0.01 s, after the start.
    assert event == {"name": "closed", "time_from_start": {"sec": 1, "nanosec": 310_000_000}}
