"""Published scenes for a Panda: distances and verdicts of coal, connections that are certified."""

from dataclasses import replace

import numpy as np
import pytest

from leadthrough.motion_planning import connect_configurations
from leadthrough_studies.connection.problems import ARCHIVE, KINDS, panda, problems
from leadthrough_studies.connection.study import STUDY, ConnectionConfig
from leadthrough_studies.study import run, selected


@pytest.fixture(scope="module")
def outcome(tmp_path_factory, recordings):
    pytest.importorskip("ompl")
    config = ConnectionConfig(str(recordings / ARCHIVE), count=1)
    return run(STUDY, config, out=tmp_path_factory.mktemp("connection"), on="local:1")


def test_distances_and_verdicts_are_those_of_coal(outcome):
    for row in outcome.rows:
        assert row["compared"] == 6
        assert row["verdicts_differ"] == 0
        assert row["distance_differs_m"] < 1e-7


def test_what_rrt_connect_solves_is_solved_and_certified(outcome):
    assert not outcome.failures
    total = outcome.report.table[-1]
    assert total["problems"] == total["ends_clear"] == len(KINDS)
    assert total["certified"] == total["solved"] == len(KINDS)
    assert total["plain_solved"] == len(KINDS)
    assert total["plain_touches"] >= 1  # it looks at places only
    assert outcome.report.summary["solved_by_plain_alone"] == []


def test_what_plain_alone_solves_is_told(outcome):
    rows = [row | {"solved": 0, "certified": 0} for row in outcome.rows]
    config = replace(ConnectionConfig(""), kinds=("cage", "box"))
    told = STUDY.report(config, selected(rows, kind="cage"))
    assert told.summary["solved_by_plain_alone"] == [["cage", 1]]
    assert [row["kind"] for row in told.table] == ["cage", "all"]


# Found touching between its configurations, twice; and found by luck: most seeds need 25,000 steps.
@pytest.mark.parametrize(("kind", "number"), [("table_under_pick", 4), ("bookshelf_tall", 2)])
def test_a_way_that_is_hard_to_find_begins_and_ends_where_asked(recordings, kind, number):
    (problem,) = problems(recordings / ARCHIVE, kind, [number])
    arm, ends = panda(), (problem.start, problem.goal)
    way = connect_configurations(arm, *ends, problem.scene)
    np.testing.assert_array_equal(way[[0, -1]], ends)
    assert arm.check(way, problem.scene).ok
