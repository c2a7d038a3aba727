from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import Recording
from leadthrough.preprocess.clean import summarize

TIMES = np.arange(101) / 50.0
WAY = np.column_stack([np.sin(TIMES), TIMES])
JOINTS = Recording(TIMES, WAY, joint_names=("a", "b"), events=(lt.Event(1, "grasp"),), name="arm")


def test_a_summary_tells_what_there_is():
    found = summarize(JOINTS)
    assert (found.kind, found.joints, found.samples) == ("joints", ("a", "b"), 101)
    assert (found.duration, found.rate) == pytest.approx((2.0, 50.0))
    assert found.upper == pytest.approx((1.0, 2.0), abs=1e-3)
    assert (found.events, found.remarks, found.report.faults) == (("grasp",), (), 0)
    assert str(found).splitlines() == [
        "arm: joints, 101 samples, 2 s at 50 Hz",
        "  range in rad (m): 0 to 1, 0 to 2",
        "  joints a, b",
        "  events grasp",
    ]
    assert found.as_dict()["report"]["read"] == 101


def test_faults_are_counted_and_gaps_of_any_length_told():
    values = WAY.copy()
    values[[3, 4]] = np.nan
    times = TIMES + 100.0 * (TIMES > 1.0)
    found = summarize(replace(JOINTS, times=times, positions=values, events=()))
    assert found.report.invalid == (3, 4)
    assert len(found.report.gaps) == 1
    assert "2 samples with missing numbers, left out: 3, 4" in str(found)


@pytest.mark.parametrize(
    ("changes", "remark"),
    [
        ({"times": 1e-9 * TIMES}, "Hz: are the times in s"),
        ({"times": 1000.0 * TIMES}, "Hz: are the times in s"),
        ({"positions": np.ones((101, 2))}, "nothing moves"),
        ({"positions": np.full((101, 2), np.nan)}, "expected some samples without missing numbers"),
        (
            {
                "positions": 400.0 * np.ones((101, 3)),
                "orientations": np.tile([1.0, 0, 0, 0], (101, 1)),
                "joint_names": None,
            },
            "positions up to 400 m: are they in m",
        ),
    ],
)
def test_what_looks_wrong_is_remarked(changes, remark):
    found = summarize(replace(JOINTS, events=(), **changes))
    assert any(remark in each for each in found.remarks)
    assert f"! {found.remarks[0]}" in str(found)


def test_only_recordings_are_summarized():
    with pytest.raises(InvalidInput, match="expected a Recording, got ndarray"):
        summarize(WAY)
