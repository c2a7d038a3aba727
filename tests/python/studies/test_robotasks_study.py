"""The study of RoboTasks, on poses made by hand in the layout of the recordings."""

import numpy as np
import pytest

from leadthrough import rotations
from leadthrough.errors import InvalidInput
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
    with pytest.raises(InvalidInput, match=r"LEADTHROUGH_DATA: expected a folder with robotasks"):
        STUDY.configure(False, 0)
