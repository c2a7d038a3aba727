"""A policy's chunks with faults: the guard's chunks keep what clamps and averages do not."""

import numpy as np
import pytest

from leadthrough.arm import JointLimits
from leadthrough_studies.chunks.peers import PEERS, followed
from leadthrough_studies.chunks.report import report
from leadthrough_studies.chunks.streams import Arrival, Stream
from leadthrough_studies.chunks.study import STUDY, ChunksConfig
from leadthrough_studies.study import run, selected


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    config = STUDY.configure(quick=True, seed=0)
    return run(STUDY, config, out=tmp_path_factory.mktemp("chunks"), on="local:1")


def test_ours_keeps_limits_and_margins_where_the_others_do_not(outcome):
    assert not outcome.failures
    table = outcome.report.table
    ours = selected(table, fault="all", method="ours")[0]
    assert (ours["streams"], ours["beyond_limits"], ours["with_contacts"]) == (7, 0, 0)
    for method in PEERS:
        row = selected(table, fault="all", method=method)[0]
        assert (row["beyond_limits"], row["with_contacts"]) == (7, 1)


def test_ours_is_on_time_and_smooth(outcome):
    rows = selected(outcome.report.table, fault="none")
    jerk = {row["method"]: row["jerk_rms"] for row in rows}
    ours = selected(rows, method="ours")[0]
    assert abs(ours["max_lag_ms"]) <= 1.0
    assert ours["reached"] == 1
    assert jerk["ours"] < min(jerk[method] for method in PEERS) / 20.0


def test_each_arm_has_its_lags_and_uses_of_limits():
    uses = dict.fromkeys(("velocity_use", "acceleration_use", "jerk_use"), 0.5)
    rows = [
        {"arm": arm, "fault": "none", "method": "ours", "lag_ms": lag, "error_rad": 0.0}
        | uses | {"velocity_use": use, "contacts": 0, "jerk_rms": 0.1, "reached": 1}
        for arm, lag, use in (("panda", 1.0, 0.5), ("ur3", 9.0, 1.5), ("ur3", 7.0, 0.5))
    ]  # fmt: skip
    found = report(ChunksConfig(("panda", "ur3"), ("none",)), rows)
    arms = {row["arm"]: row for row in selected(found.tables["arms"], fault="none")}
    assert [arms[arm]["median_lag_ms"] for arm in ("panda", "ur3")] == [1.0, 8.0]
    assert [arms[arm]["beyond_limits"] for arm in ("panda", "ur3")] == [0, 1]
    assert selected(found.table, fault="none")[0]["median_lag_ms"] == 7.0


def test_peers_do_what_they_are_known_for():
    limits = JointLimits(
        joint_names=("a",),
        lower=[-1.0],
        upper=[1.0],
        velocity=[100.0],
        acceleration=[1.0],
        jerk=[1.0],
    )
    chunks = [
        Arrival(0.0, 0.0, np.zeros((30, 1))),
        Arrival(0.1, 0.1, np.full((30, 1), 0.5)),
    ]
    stream = Stream(np.zeros((2, 1)), 1.0, chunks, list(range(1, 801)), [])
    sent = {name: followed(target, limits, stream)[:, 0] for name, target in PEERS.items()}
    assert np.array_equal(np.unique(np.round(np.diff(sent["clamp"]), 9)), [0.0, 0.1])
    older, newer = 1.0, np.exp(-0.01)
    assert sent["ensembling"][500] == pytest.approx(0.5 * newer / (older + newer))
    assert sent["moving average"][200] == pytest.approx(0.5 * (1.0 - 0.99**101))
