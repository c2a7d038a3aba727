"""Demonstrations that models take: the same answers from every model, and misalignment."""

import copy
import pickle

import numpy as np
import pytest
from kinds import kind
from motions import motion_of
from refusals import raised, refused

import leadthrough as lt
from leadthrough.errors import FitError, InvalidInput
from leadthrough.motion import lerp
from leadthrough.preprocess import by_arc_length, frechet_distance

T = np.linspace(0.0, 1.0, 60)
LINE = np.column_stack([T, 0.3 * np.sin(3.0 * T), T**2])
POINTS = lt.Trajectory(T, LINE)
POSES = lt.PoseTrajectory(T, LINE, lt.rotations.exp(np.outer(T, [0.4, 0.0, 0.2])))
LEARNERS = (
    kind("DMP"),
    kind("DMP", "poses"),
    kind("RhythmicDMP"),
    kind("RhythmicDMP", "poses"),
    kind("ProMP"),
    kind("GMR"),
    kind("TaskGMR"),
    kind("FastMarching", "poses"),
)


@pytest.fixture(params=LEARNERS, ids=str)
def case(request):
    return request.param.build(), POSES if request.param.motion == "poses" else POINTS


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
def test_a_motion_stands_for_a_demonstration_of_it(case):
    model, motion = case
    alone = model.fit([motion]).generate()
    shown = model.fit([lt.Demonstration(motion)]).generate()
    assert type(alone) is type(shown)
    assert alone.positions.tobytes() == shown.positions.tobytes()


def test_motions_and_demonstrations_may_be_mixed():
    later = lt.Trajectory(T, 1.1 * LINE)
    mixed = lt.ProMP().fit([POINTS, lt.Demonstration(later)]).generate()
    assert (
        mixed.positions.tobytes() == lt.ProMP().fit([POINTS, later]).generate().positions.tobytes()
    )


def test_different_numbers_of_columns_are_refused(case):
    model, motion = case
    if motion is POINTS:
        with pytest.raises(InvalidInput, match="same number of columns in all, got 2 and 3"):
            model.fit([motion, lt.Trajectory(T, LINE[:, :2])])


def test_a_type_that_the_model_does_not_learn_is_refused_by_name():
    refused(
        "Trajectory or PoseTrajectory, got JointTrajectory",
        lt.FastMarching().fit,
        [lt.JointTrajectory(T, LINE)],
    )


def test_none_is_too_few_but_for_a_planner(case):
    model, _ = case
    if isinstance(model, lt.FastMarching):
        model.fit([])
    else:
        assert "at least 1, got none" in str(raised(FitError, model.fit, []))


def test_other_things_and_types_are_refused_with_what_came_and_where(case):
    model, motion = case
    refused(r"demonstrations\[1\].* got int", model.fit, [motion, 3])
    refused("expected", model.fit, [motion, POSES if motion is POINTS else POINTS])
    large = type(motion)(T, 1e101 * LINE, *([motion.orientations] if motion is POSES else []))
    assert "use another unit" in str(raised(FitError, model.fit, [large]))


U = np.linspace(0.0, 1.0, 200)
PAUSED_TIMES = np.linspace(0.0, 3.0, 300)


def paused(at):
    """A reach that rests for a second at a fraction of its length."""
    u = np.interp(PAUSED_TIMES, [0.0, 2.0 * at, 2.0 * at + 1.0, 3.0], [0.0, at, at, 1.0])
    return np.column_stack([u, np.sin(6.0 * u), 0.2 * u])


def demonstration(at, motion="points"):
    path = paused(at)
    return motion_of(motion, PAUSED_TIMES, path, np.outer(path[:, 0], [0.0, 0.5, 1.0]))


ALIGNED_LEARNERS = (
    kind("ProMP"),
    kind("ProMP", "poses"),
    kind("GMR", starts=1),
    kind("DMP"),
    kind("DMP", "poses"),
    kind("DMP", "joints"),
)


@pytest.mark.parametrize("learner", ALIGNED_LEARNERS, ids=str)
def test_pauses_of_single_demonstrations_change_no_shape(learner):
    model, wanted = learner.build(), demonstration(0.5).positions
    made = model.fit([demonstration(at, learner.motion) for at in (0.2, 0.5, 0.8)]).generate()
    apart = frechet_distance(by_arc_length(made.positions, 200), by_arc_length(wanted, 200))
    assert apart < 0.03


@pytest.mark.parametrize("learner", (kind("ProMP"), kind("DMP"), kind("GMR", starts=1)), ids=str)
def test_short_pauses_change_no_letter(learner):
    shown = [each.motion for each in lt.io.lasa.load("Sharpc")[1:]]
    stopped = []
    for motion, at in zip(shown, (350, 850, 550, 250, 750, 450), strict=True):
        rows = np.insert(motion.positions, [at] * 150, motion.positions[at], axis=0)
        stopped.append(lt.Trajectory(np.linspace(0.0, 1.15 * motion.duration, len(rows)), rows))
    wanted, made = (
        by_arc_length(learner.build().fit(each).generate().positions, 200)
        for each in (shown, stopped)
    )
    assert frechet_distance(made, wanted) < 0.3  # mm, of 40


@pytest.mark.parametrize("learner", (kind("ProMP"), kind("DMP")), ids=str)
def test_a_long_pause_does_not_hide_a_short_rest(learner):
    def letter(height, at, pause):
        """A wave that rests for the last 0.8 s of ten if it is the highest, and for a pause."""
        moved = 9.2 if height == 0.5 else 10.0
        times = np.linspace(0.0, 10.0 + pause, 401)
        u = np.interp(times - np.clip(times - at, 0.0, pause), [0.0, moved], [0.0, 1.0])
        return lt.Trajectory(times, np.column_stack([u, height * np.sin(3.0 * np.pi * u)]))

    cases = ((0.5, 3.0), (0.4, 4.5), (0.45, 6.0), (0.35, 7.5))
    wanted, made = (
        by_arc_length(
            learner.build().fit([letter(*each, pause) for each in cases]).generate().positions, 200
        )
        for pause in (0.0, 7.0)
    )
    assert frechet_distance(made, wanted) < 0.01


def letter_h(rng):
    """Strokes up, half down, across, up and down, slow where they turn back."""
    corners = np.array([(-5, -8), (-5, 8), (-5, -1), (5, -1), (5, 8), (5, -8)], float)
    corners[1:] *= 1.0 + 0.1 * rng.normal(size=(5, 2))
    u, clock, times, rows = np.linspace(0.0, 1.0, 40), 0.0, [], []
    for lasting, a, b in zip((0.4, 0.25, 0.3, 0.25, 0.4), corners, corners[1:], strict=False):
        times.append(clock + lasting * u)
        rows.append(a + np.outer(0.5 - 0.5 * np.cos(np.pi * u), b - a))
        clock += lasting + 0.05 * rng.uniform()
    even = np.linspace(0.0, times[-1][-1], 200)
    return lt.Trajectory(even, lerp(even, np.concatenate(times), np.vstack(rows)))


@pytest.mark.parametrize("learner", (kind("ProMP"), kind("GMR", starts=1)), ids=str)
def test_turns_of_which_some_count_as_rests_cut_no_corner(learner):
    rng = np.random.default_rng(1)
    shown = [letter_h(rng) for _ in range(10)]
    tops = [
        [np.max(half) for half in np.array_split(each.positions[:, 1], 2)]
        for each in (*shown, learner.build().fit(shown).generate())
    ]
    np.testing.assert_allclose(tops[-1], np.mean(tops[:-1], axis=0), atol=0.4)


@pytest.mark.parametrize("learner", ALIGNED_LEARNERS, ids=str)
def test_a_rest_of_all_demonstrations_stays(learner):
    shown = [demonstration(at, learner.motion) for at in (0.48, 0.5, 0.52)]
    made = learner.build().fit(shown).generate()
    speed = np.linalg.norm(np.gradient(made.positions, made.times, axis=0), axis=1)
    assert np.mean(speed < 0.2 * speed.max()) > 0.2


def test_every_mode_stays_in_learned_certified_copied_and_loaded_skills(tmp_path):
    turn = np.outer(U, [0.0, 0.5, 1.0])
    shown = [
        motion_of("points", 2.0 * U, np.column_stack([U, height * np.sin(np.pi * U), U]), turn)
        for height in (0.4, -0.4, 0.42, -0.38, 0.38, -0.42)
    ]
    learned = lt.learn(shown, candidates=["aligned-mean", "promp"])
    learned.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    copies = (copy.copy(learned), copy.deepcopy(learned), pickle.loads(pickle.dumps(learned)))
    for each in (learned, learned.certified(None), loaded, *copies):
        assert len(each.modes) == 2
        assert each.choice == learned.choice
        for mode in (0, 1):
            made = each.generate(mode=mode).positions
            np.testing.assert_allclose(made, learned.generate(mode=mode).positions, atol=1e-9)


@pytest.mark.parametrize("learner", ALIGNED_LEARNERS, ids=str)
def test_two_routes_are_modes_in_every_family(learner, tmp_path):
    turn = np.outer(U, [0.0, 0.5, 1.0])
    shown = [
        motion_of(
            learner.motion, 2.0 * U, np.column_stack([U, height * np.sin(np.pi * U), U]), turn
        )
        for height in (0.4, -0.4, 0.42, -0.38, 0.38)
    ]
    skill = learner.build().fit(shown)
    skill.save(tmp_path / "skill.npz")
    for each in (skill, lt.load_skill(tmp_path / "skill.npz")):
        assert len(each.modes) == 2
        assert each.generate().positions[:, 1].max() == pytest.approx(0.4, abs=0.03)
        assert each.generate(mode=1).positions[:, 1].min() == pytest.approx(-0.39, abs=0.03)
    refused("mode", skill.generate, mode=2)


def test_given_phases_say_what_belongs_together():
    at = (0.2, 0.8)
    u = [
        np.interp(PAUSED_TIMES, [0.0, 2.0 * a, 2.0 * a + 1.0, 3.0], [0.0, a, a + 1e-3, 1.0])
        for a in at
    ]
    lt.ProMP().fit([demonstration(a) for a in at], phases=u)


def test_handwriting_and_single_motions_are_in_step():
    for name in lt.io.lasa.motions()[::3]:
        lt.ProMP().fit(lt.io.lasa.load(name))
    lt.DMP().fit([demonstration(0.2)])
