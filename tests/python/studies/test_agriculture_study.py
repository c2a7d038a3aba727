"""The agriculture study: one task for one target, and a recording of half a turn."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from motions import minimum_jerk

from leadthrough import PoseTrajectory, rotations
from leadthrough.models import DMP, SkillLibrary
from leadthrough_studies.agriculture import figures, printed
from leadthrough_studies.agriculture.measures import judged
from leadthrough_studies.agriculture.planners import PLANNERS
from leadthrough_studies.agriculture.recordings import replay
from leadthrough_studies.agriculture.report import report
from leadthrough_studies.agriculture.skills import LOOKUPS, chain, learn, show
from leadthrough_studies.agriculture.study import STUDY, AgricultureConfig, looked_up, on_the_arm
from leadthrough_studies.agriculture.tasks import (
    POSTURES,
    TASKS,
    amid,
    drawn,
    floor,
    load_arm,
    postures,
    targets,
)
from leadthrough_studies.study import run, selected

ARM = load_arm()
CONFIG = AgricultureConfig(("harvesting",), (0,), between=False, persons=2)


@pytest.fixture(scope="module")
def recordings_folder(tmp_path_factory):
    """A recording at 20 Hz: rest, half a turn about z while moving 0.3 m, rest, and back."""
    u = np.concatenate([np.zeros(20), np.linspace(0.0, 1.0, 60), np.ones(20)])
    there = minimum_jerk(u)
    share = np.concatenate([there, there[::-1]])[:, None]
    turned = rotations.exp(np.pi * share * [0.0, 0.0, 1.0])
    columns = [f"current_pos_{axis}" for axis in "xyz"]
    columns += [f"current_orientation_{axis}" for axis in "wxyz"]
    folder = tmp_path_factory.mktemp("recordings")
    (folder / "panda_execution").mkdir()
    np.savetxt(
        folder / "panda_execution" / "trial.csv",
        np.hstack([share * [0.3, 0.0, 0.1], turned]),
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    return folder


@pytest.fixture(scope="module")
def outcome(tmp_path_factory, recordings_folder):
    config = replace(CONFIG, recordings=str(recordings_folder))
    out = tmp_path_factory.mktemp("agriculture")
    return run(STUDY, config, out=out), out


@pytest.fixture(scope="module")
def rows(outcome):
    assert not outcome[0].failures
    return outcome[0].rows


def planned(rows, planner, **values):
    return selected(rows, study="subtasks", planner=planner, **values)


def test_every_subtask_is_reproduced_by_every_planner(rows):
    for planner in PLANNERS:
        subtasks = [row["subtask"] for row in planned(rows, planner)]
        assert subtasks == ["4-1", "4-2", "4-3", "4-4"]


@pytest.mark.parametrize("planner", ["lifted", "lauretti", "anchored"])
def test_planners_that_count_turns_always_succeed(rows, planner):
    for row in planned(rows, planner):
        assert row["succeeded"]
        assert row["npe"] < 0.05
        assert row["noe"] < 0.07


@pytest.mark.parametrize("planner", ["euler", "log"])
def test_planners_with_a_jump_spin_on_the_way_home(rows, planner):
    for row in planned(rows, planner, subtask="4-4"):
        assert not row["succeeded"]
        assert row["fastest_deg_s"] > 1000
        assert row["end_deg"] < 1e-6
        assert not row["followed"]
    for row in planned(rows, planner, subtask="4-1"):
        assert row["succeeded"]


def test_positions_do_not_depend_on_the_representation_of_the_orientation(rows):
    ours = [planner for planner in PLANNERS if planner != "lauretti"]
    errors = [[row["npe"] for row in planned(rows, planner)] for planner in ours]
    for others in errors[1:]:
        np.testing.assert_allclose(others, errors[0], rtol=1e-9)


def test_a_whole_task_is_shown_under_gravity(outcome):
    assert outcome[0].report.summary["simulated"].startswith("fit to run")
    assert (
        "The arm as simulated; transparent, as planned."
        in (outcome[1] / "simulated.html").read_text()
    )


def test_the_arm_does_what_the_default_plans(rows):
    for row in (*planned(rows, "anchored"), *selected(rows, study="whole", planner="anchored")):
        assert row["followed"]
        assert row["limits_kept"]
        assert row["arm_clear"]
        assert 1.0 <= row["slowing"] < 2.0


def test_gripper_acts_where_subtasks_end(rows):
    for row in selected(rows, study="whole", planner="anchored"):
        assert [event["does"] for event in row["gripper"]] == ["closed", "opened"]
        first, third = (event["time_s"] for event in row["gripper"])
        # After the first and the third subtask of four; slowing down is nearly even.
        assert first == pytest.approx(10 * row["slowing"], rel=0.1)
        assert third == pytest.approx(30 * row["slowing"], rel=0.1)
        assert row["home_missed_deg"] < 0.1


def test_a_recorded_half_turn_is_replayed(rows):
    own = selected(rows, study="recordings", planner="anchored", weights="by duration")
    assert [row["motion"] for row in own] == [1, 2]
    for row in own:
        assert row["turned_deg"] == pytest.approx(180, abs=0.1)
        assert row["rmse_m"] <= 1e-3
        assert row["mean_deg"] <= 0.2


@pytest.mark.parametrize("trial", ["trial1", "trial2"])
def test_motions_of_a_real_arm_are_replayed(recordings, trial):
    own = replay(file=str(recordings / "panda_execution" / f"{trial}.csv"), planner="anchored")
    assert len(own) > 30
    assert max(row["duration_s"] for row in own) > 19.0
    assert max(row["turned_deg"] for row in own) > 180.0
    for row in own:
        assert row["succeeded"]
        assert row["rmse_m"] <= 1e-3
        assert row["mean_deg"] <= 0.2


def test_the_table_quotes_the_paper(outcome):
    table = {(row["task"], row["planner"]): row for row in outcome[0].report.table}
    assert table["harvesting", "euler"]["paper_sr_mod_percent"] == "< 40"
    assert table["all", "lifted"]["paper_noe"] == 0.07
    assert table["all", "lauretti"]["paper_npe"] == 0.05
    assert table["all", "lauretti"]["sr_mod_percent"] == 100.0
    assert table["all", "anchored"]["sr_mod_percent"] == 100.0


def test_tests_of_all_pairs_are_corrected(rows, monkeypatch):
    monkeypatch.setattr(figures, "draw", lambda *_: {})
    twice = [
        row | {"repetition": i, "noe": row["noe"] * (1.0 + 0.1 * i)}
        for i in (0, 1)
        for row in selected(rows, study="subtasks")
    ]
    summary = report(replace(CONFIG, repetitions=(0, 1)), twice).summary
    tests = {(t["task"], t["planners"]): t for t in summary["wilcoxon"]}
    assert len(tests) == 2 * 10
    found = tests["all", "euler and anchored"]
    # Eight pairs, all of one sign: 2 / 2^8, ten times.
    assert found["noe_pairs"] == 8
    assert found["noe_p"] == pytest.approx(10 * 2 / 2**8, rel=0.5)
    assert found["npe_p"] == 1.0
    # Ten comparisons of eight pairs cannot come to p < 0.01, and the study says so.
    assert found["noe_least_p"] == pytest.approx(10 * 2 / 2**8)
    assert found["noe_can_show"] == 0
    assert "at least 11 pairs are needed" in summary["wilcoxon_can_show"]


def test_results_and_figures_are_written(outcome):
    out = outcome[1]
    document = json.loads((out / "results.json").read_text())
    assert len(document["table"]) == 2 * len(PLANNERS)
    for name in ("parameterisation", "targets", "measures", "subtask_4_4", "whole_tasks"):
        assert (out / f"{name}.png").stat().st_size > 10_000


def test_the_first_target_is_the_papers_and_the_grid_ours():
    first = targets("seeding")[0] - (0.2, -0.2, -0.4)
    assert ARM.forward_kinematics(np.zeros(7))[0][2] == pytest.approx(first[2], abs=0.1)
    for task in TASKS:
        grid = targets(task)
        np.testing.assert_allclose(grid[1] - grid[0], (0.0, 0.1, 0.0), atol=1e-12)
        assert len(np.unique(grid.round(6), axis=0)) == 9
    offset = targets("harvesting")[0] - targets("digging")[0]
    np.testing.assert_allclose(offset, (0.3, 0.0, 0.4), atol=1e-12)


@pytest.mark.parametrize("task", TASKS)
def test_every_demonstration_is_one_the_arm_can_do(task):
    for subtask in TASKS[task]:
        for i in (0, 2, 4, 6, 8):
            joints = show(ARM, task, subtask, i, seed=0).joints
            assert (joints.positions >= ARM.limits.lower).all()
            assert (joints.positions <= ARM.limits.upper).all()
            assert ARM.check(joints, [floor()], tolerance=1e-3).ok


@pytest.mark.parametrize("task", TASKS)
def test_subtasks_begin_where_the_last_one_ended(task):
    names = [subtask.stops for subtask in TASKS[task]]
    for before, after in pairwise(names):
        assert before[-1] == after[0]
    assert names[0][0] == names[-1][-1] == "home"


def test_a_task_for_a_target_between_others_grasps_at_it(tmp_path):
    learned = learn(ARM, "harvesting", DMP(), (0, 1), seed=0)
    grid = targets("harvesting")
    between = 0.6 * grid[0] + 0.4 * grid[1]
    motion = chain(learned, between).poses
    assert motion.duration == pytest.approx(40.0)
    assert [event.name for event in motion.events] == ["closed", "opened"]
    np.testing.assert_allclose([event.time for event in motion.events], [10.0, 30.0])
    at_grasp = motion.positions[np.searchsorted(motion.times, 10.0 - 1e-9)]
    shown = learned.shown["4-1", 0].poses.positions[-1]
    np.testing.assert_allclose(at_grasp - shown, between - grid[0], atol=2e-3)
    learned.library.save(tmp_path / "skills.npz")
    again = SkillLibrary.load(tmp_path / "skills.npz")
    assert again.subtasks("harvesting") == ("4-1", "4-2", "4-3", "4-4")
    made = again.nearest("harvesting", "4-2", grid[1]).generate()
    expected = learned.skill(TASKS["harvesting"][1], grid[1]).generate()
    np.testing.assert_array_equal(made.orientations, expected.orientations)


@pytest.fixture(scope="module")
def digging():
    return learn(ARM, "digging", DMP(), (0, 1, 3, 4), seed=0)


def test_digging_succeeds_in_the_demonstrated_posture_and_by_looking_ahead(digging):
    """The wrist turns far: only from some postures the arm can go all the way."""
    whole = chain(digging, targets("digging")[0])
    row, joints = on_the_arm(ARM, whole.poses, whole.joints)
    assert row["limits_kept"]
    assert row["arm_clear"]
    assert [event.name for event in joints.events] == ["closed", "opened"]
    for event in joints.events:  # both at the rack
        q = np.array([np.interp(event.time, joints.times, column) for column in joints.positions.T])
        rack, _ = ARM.forward_kinematics(POSTURES["rack"])
        reached, _ = ARM.forward_kinematics(q)
        np.testing.assert_allclose(reached, rack, atol=2e-3)
    ahead = ARM.follow(whole.poses, q0=whole.joints.positions[0])
    assert ARM.path_report(ahead, whole.poses).position_error.max() < 1e-5


def test_between_targets_interpolated_skills_are_closer_to_demonstrations_and_feasible(digging):
    subtask = TASKS["digging"][1]
    nearest, interpolated = (
        looked_up(ARM, digging, subtask, 0, lookup, seed=0) for lookup in LOOKUPS
    )
    for column in ("mean_m", "mean_deg", "end_m", "end_deg"):
        assert interpolated[column] < 0.5 * nearest[column]
    whole = chain(digging, amid("digging", 0), lookup="interpolated")
    row, _ = on_the_arm(ARM, whole.poses, whole.joints)
    assert row["arm_clear"]


def test_success_is_told_with_its_interval_over_persons_and_their_postures(outcome, rows):
    table = outcome[0].report.tables["persons"]
    for line in table:
        own = selected(rows, study="persons", part=line["part"], planner=line["planner"])
        own = selected(own, postures=line["postures"])
        percents = [row["sr_mod_percent"] for row in own]
        assert line["persons"] == len(own) == 2
        assert line["sr_mod_percent_median"] == pytest.approx(np.mean(percents))
        assert [line[f"sr_mod_percent_{end}"] for end in ("low", "high")] == sorted(percents)
        assert line["below_own_median"] == pytest.approx(100.0 - np.mean(percents))
        same_fit = line["planner"] in ("euler", "log", "lifted")
        assert (line["npe_gap_high"] < 1e-9) == (same_fit or line["planner"] == "anchored")
        assert line["noe_p_median"] == 1.0 or line["planner"] != "lifted"
    chosen = selected(table, postures="chosen", part="harvesting")
    for planner, percent in (("euler", 50), ("log", 50), ("lifted", 100), ("lauretti", 100)):
        (line,) = selected(chosen, planner=planner)
        assert line["sr_mod_percent_median"] == line["without_jump_percent_median"] == percent
    assert {line["part"] for line in table} == {"harvesting", "all", "4-4"}


def test_postures_of_another_person_are_others_of_the_same_arm_and_meet_the_target():
    first, second = (drawn(np.random.default_rng(seed)) for seed in (0, 1))
    digging = TASKS["digging"][1]
    at = targets("digging")[4]
    made = [postures(ARM, "digging", digging, at, each) for each in (first, second)]
    assert np.abs(made[0] - made[1]).max() > 0.1
    for rows in made:
        assert (rows >= ARM.limits.lower).all()
        assert (rows <= ARM.limits.upper).all()
        np.testing.assert_allclose(ARM.forward_kinematics(rows[2])[0], at, atol=1e-5)
    before = postures(ARM, "digging", TASKS["digging"][0], at, first)
    np.testing.assert_array_equal(before[-1], made[0][0])


def test_kernels_evenly_spaced_in_time_replay_as_the_papers_planner_does(rows):
    shown = show(ARM, "harvesting", TASKS["harvesting"][0], 0, seed=0).poses
    (lauretti,) = planned(rows, "lauretti", subtask="4-1")
    assert printed.replay_error(shown, "time") == pytest.approx(lauretti["npe"], rel=0.1)
    assert printed.replay_error(shown, "phase") > 2.0 * printed.replay_error(shown, "time")


def test_formulas_of_the_paper_hold_or_not(rows):
    errors = {(row["formula"], row["angle_deg"]): row["error"] for row in _maps(rows)}
    for angle in printed.ANGLES:
        assert errors["A13", angle] < 1e-12
        assert errors["A17", angle] < 1e-12
    assert errors["A14", 170.0] < 1e-12
    assert errors["A14", 180.0] > 0.01
    for angle in (1.0, 170.0):
        wanted = np.tan(np.radians(angle / 2.0)) - 1.0
        assert errors["A18", angle] == pytest.approx(abs(wanted), rel=1e-6)


def _maps(rows):
    return selected(rows, study="maps")


def turning(degrees, *, off=0.0):
    """A motion of 1 m about z in 1 s, off by an angle about x in the middle."""
    u = np.linspace(0.0, 1.0, 101)
    turned = rotations.exp(np.radians(degrees) * u[:, None] * [0.0, 0.0, 1.0])
    middle = ((u > 0.25) & (u < 0.75))[:, None]
    apart = rotations.exp(np.radians(off) * middle * [1.0, 0.0, 0.0])
    return PoseTrajectory(u, u[:, None] * [1.0, 0.0, 0.0], rotations.compose(apart, turned))


def test_orientation_errors_are_fractions_of_the_rotation():
    found = judged(turning(90, off=9), turning(90))
    assert found["npe"] == pytest.approx(0.0, abs=1e-12)
    assert found["mean_deg"] == pytest.approx(9 * 49 / 101)
    assert found["noe"] == pytest.approx(0.1 * 49 / 101)
    assert found["noe_of_angle"] == pytest.approx(found["noe"])
    assert found["largest_deg"] == pytest.approx(9.0)
    assert not found["succeeded"]  # 9 degrees in 10 ms


def test_a_motion_that_returns_to_its_start_has_no_normalised_error():
    found = judged(turning(360), turning(360))
    assert found["noe"] is None
    assert found["turned_deg"] == pytest.approx(360)
    assert found["succeeded"] == 0  # 360 degrees a second
    assert judged(turning(300), turning(300))["succeeded"] == 1
