"""Bounds of a fraction hold as often as they say, also where one stops as they are narrow."""

import numpy as np
import pytest
from refusals import refused
from scipy import stats

from leadthrough.validation import TargetRegion, clopper_pearson, confidence_sequence
from leadthrough.validation.validate import Findings

GOALS = TargetRegion([0.0, 0.0, 0.0], [1.0, 1.0, 1.0])
REPETITIONS = 200


@pytest.mark.parametrize(("successes", "runs"), [(0, 7), (7, 7), (3, 10), (950, 1000)])
def test_clopper_and_pearson_are_those_of_scipy(successes, runs):
    theirs = stats.binomtest(successes, runs).proportion_ci(0.9, method="exact")
    ours = clopper_pearson(successes, runs, confidence=0.9)
    assert ours == pytest.approx((theirs.low, theirs.high), abs=1e-12)


@pytest.mark.parametrize(("successes", "runs"), [(0, 7), (7, 7), (3, 10), (950, 1000)])
def test_bounds_for_any_time_are_wider_than_those_for_one(successes, runs):
    low, high = confidence_sequence(successes, runs)
    inner = clopper_pearson(successes, runs)
    assert 0.0 <= low <= inner[0] <= inner[1] <= high <= 1.0
    assert high - low < 2.5 * (inner[1] - inner[0])


def test_wrong_counts_are_refused():
    refused("successes", clopper_pearson, 8, 7)
    refused("confidence", confidence_sequence, 3, 7, confidence=1.0)


def findings(rng, limit):
    """Of batches of 20 queries that succeed where no coordinate is above a limit."""
    found = Findings(GOALS, 0.95)
    while True:
        goals = rng.uniform(GOALS.lower, GOALS.upper, (20, 3))
        found.add(
            [
                {"number": 0, "start": [0.0], "goal": goal.tolist(), "detail": "",
                 "cause": "" if goal.max() <= limit else "too far"}
                for goal in goals
            ]
        )  # fmt: skip
        yield found


def test_intervals_cover_the_truth_in_95_of_100_repetitions():
    limit = 0.97
    truth = limit**3
    covered = {"fixed": 0, "stopped": 0, "part": 0}
    for seed in range(REPETITIONS):
        growing = findings(np.random.default_rng(seed), limit)
        stopped = next(found for found in growing if np.ptp(found.sequence) <= 0.12)
        low, high = stopped.sequence
        covered["stopped"] += low <= truth <= high
        while stopped.runs < 400:
            fixed = next(growing)
        low, high = fixed.interval
        covered["fixed"] += low <= truth <= high
        # All of a part about the middle succeeds if it ends before the limit.
        part = fixed.largest_part(0.98)
        side = 0.0 if part is None else part.upper[0] - part.lower[0]
        covered["part"] += min(1.0, (limit - 0.5 + 0.5 * side) / max(side, 1e-9)) ** 3 >= 0.98
    assert min(covered.values()) >= 0.95 * REPETITIONS, covered
