"""Spoiled demonstrations are found, and leaving them out does no harm."""

import numpy as np
import pytest
from cli.command_line import facts
from demonstration_quality import spoiled as spoiling
from demonstration_quality.spoiled import copies
from refusals import refused
from sklearn.metrics import roc_auc_score

import leadthrough as lt
from leadthrough.demonstration_quality.judge import TRAITS, peculiarities
from leadthrough.validation import TargetRegion
from leadthrough_studies.robotasks.study import read

FAULTS = {
    "jerky": {"jerky"},
    "stalled": {"stalled"},
    "outlier": {"outlier"},
    "other_mode": {"outlier", "another mode"},
    "misaligned": {"misaligned"},
}


@pytest.fixture(scope="module")
def lasa():
    return {name: [each.motion for each in lt.io.lasa.load(name)] for name in lt.io.lasa.motions()}


def area(sets, seed):
    """Under the curve of the suspicion, for all demonstrations of spoiled copies."""
    is_spoiled, suspicions = [], []
    for _, motions, spoiled in copies(sets, seed):
        found = peculiarities(motions)
        suspicions += list(np.max([found[trait] for trait in TRAITS], axis=0))
        is_spoiled += [i == spoiled for i in range(len(motions))]
    return roc_auc_score(is_spoiled, suspicions)


def test_spoiled_demonstrations_of_handwriting_are_found(lasa):
    assert area(lasa, 0) >= 0.95


def test_spoiled_demonstrations_of_poses_are_found(recordings):
    files = sorted((recordings / "robotasks").glob("*.npy"))
    sets = {file.stem: [each.motion for each in read(str(file))] for file in files}
    assert area(sets, 0) >= 0.95


def thinned(motions, every=20):
    return [lt.Trajectory(each.times[::every], each.positions[::every]) for each in motions]


FAULTY = {fault.__name__: i for i, fault in enumerate(spoiling.FAULTS)}


@pytest.mark.parametrize("fault", FAULTY)
def test_the_fault_has_a_name_and_leaving_it_out_never_harms(lasa, fault):
    sets = {name: thinned(lasa[name]) for name in ("Spoon", "Worm")}
    name, motions, spoiled = list(copies(sets, 1))[FAULTY[fault]]
    judgement = lt.judge_demonstrations(motions, model=lt.ProMP(weights=10))
    verdict = judgement.verdicts[spoiled]
    assert FAULTS[name] & set(verdict.faults)
    assert judgement.error_without <= judgement.error
    assert all(judgement.verdicts[i].faults for i in judgement.remove)
    if name in ("outlier", "other_mode"):
        assert judgement.remove == (spoiled,)
        assert verdict.worth < 0.0 and judgement.error_without < judgement.error


def test_two_on_another_path_are_another_mode(lasa):
    motions = thinned(lasa["Sine"])
    for i in (1, 4):
        path = motions[i].positions * [1.0, -1.0]
        motions[i] = lt.Trajectory(motions[i].times, path)
    verdicts = lt.judge_demonstrations(motions, model=lt.ProMP(weights=10)).verdicts
    assert [i for i, each in enumerate(verdicts) if "another mode" in each.faults] == [1, 4]


def test_a_goal_far_from_all_demonstrated_ones_is_suggested_next(lasa):
    motions = [
        lt.Trajectory(each.times, each.positions + np.linspace(0, 1, 50)[:, None] * [5.0 * i, 0])
        for i, each in enumerate(thinned(lasa["Line"]))
    ]
    goals = TargetRegion([0.0, -1.0], [90.0, 1.0])  # demonstrated: from 0 to 30
    found = lt.judge_demonstrations(motions, goals=goals)
    assert found.next.goal[0] > 75.0
    assert found.next.uncertainty > 0.0


def test_two_are_judged_and_of_three_the_outlier_is_found(lasa):
    motions = thinned(lasa["Sine"])[:2]
    two = lt.judge_demonstrations(motions, model=lt.ProMP(weights=10))
    assert [each.faults for each in two.verdicts] == [(), ()]
    other = lt.Trajectory(motions[0].times, motions[0].positions * [1.0, -1.0])
    three = lt.judge_demonstrations([*motions, other], model=lt.ProMP(weights=10))
    assert ["outlier" in each.faults for each in three.verdicts] == [False, False, True]


def test_too_few_are_refused(lasa):
    refused("at least 2", lt.judge_demonstrations, lasa["Line"][:1])


def test_the_command_names_the_recordings(lasa, tmp_path):
    _, motions, spoiled = list(copies({"a": thinned(lasa["Spoon"]), "b": lasa["Worm"]}, 1))[2]
    for i, motion in enumerate(motions):
        lt.write_motion(motion, tmp_path / f"shown{i}.csv")
    found = facts("judge", tmp_path, "--rest", "inf", "--goals", "5,5", "--set", "weights=10")
    marked = [each["recording"] for each in found["recordings"] if each["leave_out"]]
    assert [f"shown{spoiled}" in name for name in marked] == [True]
    assert found["without_those"] < found["left_out_error"]
    assert len(found["show_next"]) == 2


def test_long_recordings_are_judged_by_some_of_their_samples():
    u = np.linspace(0.0, 1.0, 20_000)
    shown = [
        lt.Trajectory(20.0 * u, np.column_stack([u, bow * np.sin(np.pi * u)]))
        for bow in (0.18, 0.2, 0.22)
    ]
    few = [each[4::5] for each in shown]
    whole, part = lt.judge_demonstrations(shown), lt.judge_demonstrations(few)
    assert whole.error == part.error
    assert [each.worth for each in whole.verdicts] == [each.worth for each in part.verdicts]
