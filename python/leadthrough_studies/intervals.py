"""Intervals of the figures of studies: medians, shares and correlations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import binom, binomtest, rankdata, spearmanr

from leadthrough.check import Float64Array

_CONFIDENCE = 0.95
_RESAMPLES = 2000


def median(values: Sequence[float] | Float64Array) -> dict[str, float]:
    """The median, and the order statistics that hold the true one with 95 % at least.

    Their ranks are those of the sign test: the count below the true median is binomial. Below six
    values there are none, and the interval is that of all values.
    """
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    left_out = int(binom.ppf(0.5 * (1.0 - _CONFIDENCE), len(ordered), 0.5)) - 1
    low = max(left_out, 0)
    return {
        "median": float(np.median(ordered)),
        "low": float(ordered[low]),
        "high": float(ordered[-1 - low]),
    }


def share(hits: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share, in percent."""
    if not count:
        return 0.0, 100.0
    found = binomtest(hits, count).proportion_ci(_CONFIDENCE, method="wilson")
    return 100.0 * float(found.low), 100.0 * float(found.high)


def correlation(first: Sequence[float], second: Sequence[float]) -> dict[str, float]:
    """Spearman's correlation with a bootstrap interval of 95 %."""
    pairs = np.array([first, second], dtype=np.float64)
    rng = np.random.default_rng(0)
    picks = rng.integers(pairs.shape[1], size=(_RESAMPLES, pairs.shape[1]))
    ranks = rankdata(pairs[:, picks], axis=2)
    ranks -= ranks.mean(axis=2, keepdims=True)
    above = (ranks[0] * ranks[1]).sum(axis=1)
    spread = np.sqrt((ranks[0] ** 2).sum(axis=1) * (ranks[1] ** 2).sum(axis=1))
    found = above[spread > 0.0] / spread[spread > 0.0]  # one pair alone has none
    low, high = np.quantile(found, (0.5 * (1.0 - _CONFIDENCE), 0.5 * (1.0 + _CONFIDENCE)))
    value = float(spearmanr(*pairs).statistic)
    return {"spearman": value, "low": float(low), "high": float(high)}
