"""The comparison of all models, on one motion and on poses made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import rotations
from leadthrough.models import CLFDM, DMP, LPVDS, AlignedMean, FastMarching, ProMP
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies.comparison import (
    STUDY,
    material,
    measures,
    methods,
    on_arms,
    pushed_arm,
    rivals,
    study,
)
from leadthrough_studies.comparison.methods import NearestShifted
from leadthrough_studies.comparison.pushes import after_push, online_call, time_at
from leadthrough_studies.study import Report, run, selected

U = np.linspace(0.0, 1.0, 1000)
FEW = ("FastMarching", "ProMP", "CLF-DM", "FSM-DM", "nearest demonstration, shifted")
OF_POSES = ("FastMarching", "ProMP", "nearest demonstration, shifted")


def recorded(offset):
    """Positions in cm along a bow that starts at an offset, and a turn about the vertical."""
    positions = np.column_stack([30.0 + 20.0 * U, offset * (1 - U), 30.0 + 5 * np.sin(np.pi * U)])
    down = np.tile([0.0, 1.0, 0.0, 0.0], (len(U), 1))
    turned = rotations.compose(rotations.exp(np.outer(U, [0.0, 0.0, 0.8])), down)
    return np.hstack([positions, turned])


def test_all_parts_are_in_the_report_and_a_second_start_has_nothing_left_to_do(tmp_path):
    file = tmp_path / "bow.npy"
    np.save(file, np.stack([recorded(x) for x in (-4.0, 0.0, 4.0)]))
    config = study.ComparisonConfig(
        ("Angle",),
        FEW,
        courses=(("reach over a box", ""),),
        motions_of_poses=(("bow", str(file)),),
        poses=OF_POSES,
        motions_of_joints=material.MOTIONS_OF_JOINTS,
        joints=("DMP",),
        online=("DMP",),
        left_out=1,
        folds=0,
        pushed=1,
        starts=50,
    )
    outcome = run(STUDY, config, out=tmp_path / "out")
    assert not outcome.failures
    table = outcome.report.table
    assert {row["part"] for row in table} == {"IN", "LOO", "bow", "reach over a box"}
    assert len(table) == 3 * len(FEW) + len(OF_POSES)
    for row in table:
        assert row["panda_executed"] == row["panda_reachable"] == row["panda_clear"] == 1
        assert row["goal_end_mm"] < 1e-3
    for row in selected(table, part="LOO"):
        assert row["SEA_mm2"] < 1000.0
        assert row["end_mm"] < 1e-6
    pushes = outcome.report.tables["pushes"]
    of_the_arm = outcome.report.tables["pushed_arm"]
    assert len(pushes) == 2 * len(FEW) + len(OF_POSES) + 1
    assert [row["method"] for row in of_the_arm] == ["DMP"]
    for row in of_the_arm:
        assert 20.0 < row["displaced_mm"] < 200.0
    for row in [*pushes, *of_the_arm]:
        assert row["refused"] == 0
        assert 0.0 < row["push_any_fade_mm"] <= row["push_Frechet_mm"]
    printed = {line["method"]: line for line in outcome.report.summary["table_2"]}
    assert printed["SEDS"]["SEA_printed"] == 8.18e5
    assert printed["FSM-DM"]["SEA_mm2"] == selected(table, part="IN", method="FSM-DM")[0]["SEA_mm2"]
    (shown_stable, *_) = outcome.report.summary["stability"]
    assert shown_stable["arrived"] == shown_stable["starts"] == 50
    assert set(outcome.report.figures) >= {"figure_16", "figure_17", "figure_18", "stability"}
    assert selected(table, part="LOO", method="CLF-DM")[0]["violations"] == 0
    shown = (tmp_path / "out" / "comparison.html").read_text()
    assert all(text in shown for text in ("Table 2", "Handwriting, left out", "Angle", "FSM-DM"))
    quick = replace(STUDY, report=lambda *_: Report([]))  # the figures are drawn already
    again = run(quick, replace(config), out=tmp_path / "out")
    assert again.rows == outcome.rows


GO_ON = {
    "steps": DMP(),
    "policy": FastMarching(),
    "system": CLFDM(),
    "condition": ProMP(),
    "correction": AlignedMean(),
    "shift": NearestShifted(),
}


def bent(height):
    progress = minimum_jerk(np.linspace(0.0, 1.0, 120))
    path = np.column_stack([40.0 * progress, height * np.sin(np.pi * progress)])
    return lt.Demonstration(lt.Trajectory(np.linspace(0.0, 2.0, 120), path))


@pytest.mark.parametrize("name", GO_ON)
def test_a_pushed_tool_goes_on_from_there_to_the_goal_at_its_present_phase(name):
    skill = GO_ON[name].fit([bent(height) for height in (9.0, 10.0, 11.0)])
    place = np.array([20.0, 14.0])
    path = after_push(skill, start=np.zeros(2), goal=None, at=0.5, place=place)
    np.testing.assert_allclose(path[0], place)
    np.testing.assert_allclose(path[-1], [40.0, 0.0], atol=0.5)
    assert path[:, 0].min() > 19.0  # no new motion from the start
    assert np.linalg.norm(path[1] - place) < 2.0


@pytest.mark.parametrize("name", [name for name in GO_ON if name != "shift"])
def test_online_calls_repeat_the_skills_own_motion_until_the_tool_is_measured_elsewhere(name):
    skill, period = GO_ON[name].fit([bent(height) for height in (9.0, 10.0, 11.0)]), 0.01
    own, place = skill.generate(start=np.zeros(2)), np.array([20.0, 14.0])
    call = online_call(skill, start=np.zeros(2), goal=None, period=period)
    half = int(time_at(own, 0.5) / period)
    made = np.array([call(None) for _ in range(half)])
    apart = np.linalg.norm(made[:, None] - own.positions[None], axis=2).min(axis=1)
    assert apart.max() < 0.5
    np.testing.assert_allclose(made[-1], own.at(own.times[0] + period * half), atol=3.0)
    after = [call(place), *(call(None) for _ in range(3 * half))]
    assert np.linalg.norm(after[0] - place) < 1.0
    np.testing.assert_allclose(after[-1], [40.0, 0.0], atol=1.0)


def test_a_pushed_arm_goes_on_to_the_goal_where_friction_leaves_it():
    shown = pushed_arm.before_the_arm(material.course("reach over a box", None, 0))
    row = pushed_arm.responses(DMP().fit(shown[1:]), shown[0].motion)
    assert 20.0 < row["displaced_mm"] < 200.0  # it yields, and only as long as it is pushed
    assert row["push_at_75_mm"] < row["displaced_mm"]


def test_auto_learning_keeps_the_demonstrations_and_adds_paths_of_low_kappa():
    shown = lt.io.lasa.load("Angle")
    plain = methods.POINTS["FML, paper's setting"][0].fit(shown)
    same, more = (
        replace(methods.POINTS["FML, auto-learning"][0], threshold=threshold).fit(shown)
        for threshold in (0.0, 1.0)
    )
    assert (same.velocity_map == plain.velocity_map).all()
    assert (more.velocity_map >= plain.velocity_map).all()
    assert more.velocity_map.sum() > plain.velocity_map.sum()


def test_a_held_primitive_waits_and_then_makes_the_motion_that_a_push_leaves():
    skill, place = DMP().fit([bent(10.0)]), np.array([20.0, 14.0])
    query = {"start": np.zeros(2), "goal": None, "at": 0.5, "place": place}
    after, held = after_push(skill, **query), after_push(skill, **query, held=0.25)
    late = lt.preprocess.frechet_distance(by_arc_length(after, 100), by_arc_length(held, 100))
    assert late < 1.0


def test_a_response_to_pushes_is_0_for_the_demonstration_with_any_fading_of_the_push():
    shown = bent(10.0).motion.positions
    path = by_arc_length(shown, 200)

    def back(at, place, held, part=1.0):
        rest = path[int(200 * at) :]
        left = np.maximum(1.0 - np.linspace(0.0, 1.0, len(rest)) / part, 0.0)[:, None]
        return rest + left * (place - rest[0])

    slow = measures.response_to_pushes(back, shown, clock=True)
    assert slow["push_Frechet_mm"] == slow["push_any_fade_mm"] == slow["held_Frechet_mm"]
    assert slow["push_Frechet_mm"] < 0.2  # resampling

    def quick(at, place, held):
        return back(at, place, held, part=0.25)

    again = measures.response_to_pushes(quick, shown, clock=False)
    assert again["push_any_fade_mm"] < 0.2 < again["push_Frechet_mm"]


def test_inner_cross_validation_takes_the_model_that_predicts_left_out_demonstrations():
    class Guess:
        def __init__(self, value):
            self.value = value

        def fit(self, shown):
            return self.value + 0 * len(shown)

    def error(skill, left_out):
        return abs(skill - sum(left_out))

    models = [Guess(1.0), Guess(2.0), Guess(5.0)]
    assert methods.chosen(models, [2.0, 2.0, 2.0], error, folds=2).value == 2.0
    assert methods.chosen(models, [5.0] * 3, error, folds=3).value == 5.0
    assert methods.chosen(models, [5.0] * 3, error, folds=0).value == 2.0


def test_arm_refuses_what_it_cannot_reach_and_tells_how_much_slower_it_is():
    t = np.linspace(0.0, 1.0, 50)
    made = lt.Trajectory(t, np.outer(t**2 * (3 - 2 * t), [40.0, 20.0]))
    row = on_arms.on_arm("panda", on_arms.on_paper("panda", made))
    assert row["executed"] == 1
    assert row["slower"] >= 1.0
    assert row["begins_at"] < 0.2
    far = replace(made, positions=20.0 * made.positions)
    assert on_arms.on_arm("panda", on_arms.on_paper("panda", far))["executed"] == 0


def test_direction_error_is_small_for_the_system_that_made_the_motion():
    skill = LPVDS(components=3).fit(lt.io.lasa.load("Angle"))
    made = skill.generate(duration=skill.generate().duration * skill.pace, dt=0.005)
    whole = measures.direction_error(skill, made)
    assert whole < 0.15  # how it comes to rest at the goal is not the system's own
    assert measures.direction_error(skill, made, slowest=0.2) < whole
    assert measures.direction_error(skill, made, smoothing=1.0) == pytest.approx(whole, rel=0.2)
    backwards = lt.Trajectory(made.times, made.positions[::-1])
    assert measures.direction_error(skill, backwards) > 1.0


SHARE = np.linspace(0.0, 1.0, 120)
RIVALS = {
    "gmr": rivals.TimeRegression(components=10),
    "movement_primitives": rivals.ConditionedPrimitive(weights=10),
    "mp_pytorch": rivals.ProDMP(weights=15),
}


def bow(offset):
    progress = minimum_jerk(SHARE)
    columns = [0.4 * progress, offset * (1.0 - progress) + 0.2 * np.sin(np.pi * progress)]
    return lt.Demonstration(lt.Trajectory(2.0 * SHARE, np.column_stack(columns)))


@pytest.mark.parametrize("library", RIVALS)
def test_rival_predicts_a_demonstration_between_those_shown(library):
    if rivals.LIBRARIES[library] in rivals.MISSING:
        pytest.skip(f"{library} is not installed")
    tested = bow(0.0).motion
    skill = RIVALS[library].fit([bow(x) for x in (-0.06, -0.02, 0.02, 0.06)])
    made = skill.generate(start=tested.positions[0], goal=tested.positions[-1])
    assert made.duration == pytest.approx(2.0)
    np.testing.assert_allclose(made.positions[[0, -1]], tested.positions[[0, -1]], atol=2e-3)
    wanted = np.column_stack([np.interp(made.times, tested.times, x) for x in tested.positions.T])
    assert np.abs(made.positions - wanted).max() < 0.015


def test_columns_of_poses_lead_back_to_the_poses_that_were_shown():
    down = np.tile([0.0, 1.0, 0.0, 0.0], (len(SHARE), 1))
    turned = rotations.compose(rotations.exp(np.outer(SHARE - 1.0, [0.0, 0.5, 2.5])), down)
    shown = lt.PoseTrajectory(
        SHARE, np.outer(SHARE, [0.1, 0.2, 0.3]), rotations.align_signs(turned)
    )
    skill = rivals.OfPoses(NearestShifted()).fit([lt.Demonstration(shown)])
    start, goal = ((shown.positions[i], shown.orientations[i]) for i in (0, -1))
    made = skill.generate(start=start, goal=goal)
    assert rotations.distance(made.orientations, shown.orientations).max() < 1e-7
    np.testing.assert_allclose(made.positions, shown.positions, atol=1e-12)


def test_simulated_motions_are_the_same_for_the_same_seed():
    first, again = (material.poses("reach by hand", None, 3) for _ in range(2))
    assert len(first) == 6
    assert (first[0].motion.orientations == again[0].motion.orientations).all()
    other = material.course("reach over a box", None, 4)
    assert (
        other[0].motion.positions
        != material.course("reach over a box", None, 5)[0].motion.positions
    ).any()
