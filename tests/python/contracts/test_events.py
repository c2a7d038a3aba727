"""Every stage hands events on: they stay where on the way they happened."""

import json
from dataclasses import replace

import numpy as np
import pytest
from kinds import kind
from motions import arm, minimum_jerk, motion_of, with_derivatives

import leadthrough as lt
from leadthrough.preprocess import align_by_arc_length, align_by_time_warping, segment

CLOSED, OPENED = lt.Event(1.3, "closed"), lt.Event(2.0, "opened")
TIMES = np.linspace(0.0, 2.0, 201)
S = minimum_jerk(TIMES / 2.0)
START = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])


BOW = np.column_stack([0.3 * S, 0.05 * np.sin(np.pi * S), 0.1 * S])
ANGLES = 2.0 * np.pi * TIMES  # of two rounds in twice the time
ROUNDS = 0.1 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES), 0.0 * TIMES])


def demonstrated(kind):
    """A bow of points or poses, or joints of a UR3, with two events."""
    if kind == "joints":
        q = START + np.outer(S, [0.6, 0.2, -0.3, 0.3, 0.2, 0.8])
        names = arm("ur3").joint_names
        return lt.JointTrajectory(TIMES, q, joint_names=names, events=(CLOSED, OPENED))
    return motion_of(kind, TIMES, BOW, np.outer(S, [0.0, 0.0, 2.0]), (CLOSED, OPENED))


def at(motion, time):
    return np.array([np.interp(time, motion.times, column) for column in motion.positions.T])


def assert_kept(made, given, *, atol):
    """The same events, at the same places on the way."""
    assert [event.name for event in made.events] == [event.name for event in given.events]
    for new, old in zip(made.events, given.events, strict=True):
        np.testing.assert_allclose(at(made, new.time), at(given, old.time), atol=atol)


@pytest.mark.parametrize(
    "learner",
    [
        *(kind(family, "poses") for family in ("DMP", "ProMP", "FastMarching")),
        *(kind(family, components=12) for family in ("GMR", "TaskGMR")),
        kind("FastMarching", timing="constant"),
    ],
    ids=str,
)
def test_models_generate_them_where_they_were_demonstrated(learner):
    given = demonstrated(learner.motion)
    skill = learner.build().fit([given])
    made = skill.generate(duration=5.0)
    assert_kept(made, given, atol=0.02)
    assert made.events[1].time == pytest.approx(5.0, abs=0.05)


def test_fast_marching_keeps_them_backwards_and_in_what_it_learns_itself():
    skill = lt.FastMarching().fit([demonstrated("points")])
    back = skill.generate(start=(0.3, 0.0, 0.1), goal=(0.0, 0.0, 0.0))
    assert [event.name for event in back.events] == ["opened", "closed"]
    np.testing.assert_allclose(
        at(back, back.events[1].time), at(demonstrated("points"), 1.3), atol=0.01
    )
    line = np.linspace([0.0, 0.2, 0.0], [0.3, 0.2, 0.0], 50)
    assert skill.with_experience(line).learned[0].events == skill.demonstrated[0].events


@pytest.mark.parametrize("motion", ["points", "poses"])
def test_rhythms_have_them_in_every_round(motion):
    happened = (lt.Event(0.5, "tap"), lt.Event(2.7, "tap"))
    model = kind("RhythmicDMP", motion, period=2.0).build()
    skill = model.fit([motion_of(motion, 2.0 * TIMES, ROUNDS, 0.0 * ROUNDS, happened)])
    made = skill.generate(duration=5.0, period=2.0)
    assert [event.name for event in made.events] == ["tap"] * 3
    np.testing.assert_allclose([event.time for event in made.events], [0.6, 2.6, 4.6])


def test_a_rhythmic_promp_gathers_them_from_all_rounds():
    happened = (lt.Event(0.5, "tap"), lt.Event(2.7, "tap"))
    given = lt.Trajectory(2.0 * TIMES, ROUNDS[:, :2], happened)
    model = lt.ProMP(basis="rhythmic", weights=12)
    skill = model.fit([given], phases=[TIMES])
    (event,) = skill.generate(duration=1.0).events
    assert event.time == pytest.approx(0.3)


def test_libraries_interpolate_and_save_them(tmp_path):
    library = lt.SkillLibrary()
    for target, when in ((0.0, 0.8), (1.0, 1.2)):
        shown = replace(demonstrated("poses"), events=(lt.Event(when, "closed"),))
        skill = kind("DMP", "poses").build().fit([shown])
        library = library.with_skill(skill, task="dig", subtask="reach", target=(target,))
    library.save(tmp_path / "skills.npz")
    between = lt.SkillLibrary.load(tmp_path / "skills.npz").interpolated("dig", "reach", (0.25,))
    (event,) = between.generate().events
    assert event.time == pytest.approx(0.9)


@pytest.mark.parametrize("align", [align_by_time_warping, align_by_arc_length])
def test_aligned_demonstrations_keep_them(align):
    shown = [
        demonstrated("poses"),
        replace(demonstrated("poses"), times=1.0 + 2.0 * TIMES**1.2, events=(lt.Event(3.0, "x"),)),
    ]
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
    position, turned = arm("ur3").forward_kinematics(START)
    way = position + np.outer(S, [0.05, 0.1, 0.0])
    hurried = 0.1 * TIMES
    happened = (lt.Event(0.13, "closed"),)
    motion = lt.PoseTrajectory(hurried, way, np.tile(turned, (len(S), 1)), happened)
    made = arm("ur3").follow(motion, q0=START, on_rate_limit=too_fast)
    (event,) = made.events
    reached, _ = arm("ur3").forward_kinematics(at(made, event.time))
    np.testing.assert_allclose(reached, at(motion, 0.13), atol=1e-4)


@pytest.mark.parametrize("timed", [lt.retime, lt.keep_timing])
def test_a_new_time_law_leaves_them_on_the_path(timed):
    shown = replace(
        demonstrated("joints"), times=5.0 + 0.2 * TIMES, events=(lt.Event(5.26, "closed"),)
    )
    assert_kept(timed(shown, arm("ur3").limits), shown, atol=1e-4)


def test_they_come_when_a_hold_begins():
    shown = replace(demonstrated("joints"), events=(lt.Event(float(TIMES[100]), "closed"),))
    made = lt.retime(shown, arm("ur3").limits, dwell_times={100: 0.5})
    (event,) = made.events
    resting = made.times[np.abs(made.velocities).max(axis=1) == 0.0]
    hold = resting[(resting > 0.0) & (resting < made.times[-1])]
    assert event.time == pytest.approx(hold[0], abs=2e-3)
    assert hold[-1] - hold[0] == pytest.approx(0.5, abs=2e-3)


def test_exported_trajectories_keep_them(tmp_path):
    happened = (lt.Event(8.3, "closed"),)
    shown = with_derivatives(replace(demonstrated("joints"), times=7.0 + TIMES, events=happened))
    assert shown.events == happened
    lt.io.joint_trajectory.write_json(shown, tmp_path / "arm.json")
    (event,) = json.loads((tmp_path / "arm.json").read_text())["events"]
    # The first sample is due one step, 0.01 s, after the start.
    assert event == {"name": "closed", "time_from_start": {"sec": 1, "nanosec": 310_000_000}}
