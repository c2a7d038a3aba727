"""Sets of recordings in the comparison."""

import numpy as np
import pytest
from refusals import refused

from leadthrough_studies.comparison import recordings
from leadthrough_studies.comparison.rivals import ConditionedPrimitive
from leadthrough_studies.comparison.study import STUDY, configure

TIMES = np.linspace(0.0, 1.0, 50)


def write_set(folder, name, count=3):
    arrays = {}
    for i in range(count):
        path = np.column_stack([TIMES, (0.2 + 0.05 * i) * np.sin(3.0 * TIMES)])
        arrays |= {f"times_{i}": TIMES, f"positions_{i}": 100.0 * path}
    np.savez(folder / f"{name}.npz", **arrays)


def test_each_demonstration_of_each_set_is_left_out(tmp_path):
    for name in ("a", "b"):
        write_set(tmp_path, name)
    config = STUDY.of_recordings(configure(quick=True, seed=0), tmp_path)
    chosen = [task for task in STUDY.tasks(config) if task.arguments["method"] == "AlignedMean"]
    assert [task.arguments["name"] for task in chosen] == ["a", "b"]
    (row,) = chosen[0].function(**chosen[0].arguments, **chosen[0].files)
    assert 0.0 < row["Frechet"] < 10.0  # in the set's unit


def test_ratios_are_geometric_means_over_the_sets():
    rows = [
        {"set": name, "method": method, **dict.fromkeys(recordings.ERRORS, error)}
        for name, errors in (("a", (1.0, 0.5)), ("b", (10.0, 20.0)))
        for method, error in zip(("FastMarching", "other"), errors, strict=True)
    ]
    reference, other = recordings.relative(rows, reference="FastMarching", seed=0)
    assert reference["DTW"] == 1.0
    assert other["DTW"] == pytest.approx(1.0)  # of 0.5 and 2
    assert other["DTW_most"] == pytest.approx(2.0)
    assert [other["DTW_low"], other["DTW_high"]] == pytest.approx([0.5, 2.0])


def test_a_set_that_a_method_refuses_does_not_count_for_it():
    rows = [{"set": "a", "method": "FastMarching", **dict.fromkeys(recordings.ERRORS, 1.0)}]
    rows += [{"set": "b", "method": "FastMarching", **dict.fromkeys(recordings.ERRORS, 1.0)}]
    rows += [{"set": "a", "method": "other", **dict.fromkeys(recordings.ERRORS, 0.7)}]
    rows += [{"set": "b", "method": "other", "refused": "no mean"}]
    other = recordings.relative(rows, reference="FastMarching", seed=0)[1]
    assert (other["sets"], other["refused"]) == (1, 1)
    assert other["Frechet"] == pytest.approx(0.7)


def test_a_folder_without_sets_is_refused(tmp_path):
    refused("--recordings: expected a folder with sets", recordings.sets_in, tmp_path)


@pytest.mark.parametrize("shift", ["path", "time"])
def test_the_peer_s_motion_meets_the_ends_that_are_asked_for(tmp_path, shift):
    pytest.importorskip("movement_primitives")
    write_set(tmp_path, "a", count=5)
    shown = recordings.read(tmp_path / "a.npz")
    for variance in (3e-2, np.inf):
        peer = ConditionedPrimitive(weights=10, variance=variance, shift=shift)
        made = peer.fit(shown).generate(start=(-5.0, 3.0), goal=(110.0, 20.0))
        np.testing.assert_allclose(made.positions[[0, -1]], [(-5.0, 3.0), (110.0, 20.0)], atol=1e-9)


def test_a_peer_that_is_not_shifted_leaves_its_ends_where_it_has_them(tmp_path):
    pytest.importorskip("movement_primitives")
    write_set(tmp_path, "a", count=5)
    shown = recordings.read(tmp_path / "a.npz")
    peer = ConditionedPrimitive(weights=10, variance=np.inf, shift="nothing")
    made = peer.fit(shown).generate(start=(-5.0, 3.0), goal=(110.0, 20.0))
    np.testing.assert_allclose(made.positions[0], (0.0, 0.0), atol=1.0)
