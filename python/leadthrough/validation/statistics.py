"""Bounds of a fraction from successes and failures, and the region in which they are high enough.

Source: Clopper and Pearson 1934, "The use of confidence or fiducial limits illustrated in the case
of the binomial", Biometrika 26(4). Robbins 1970, "Statistical methods related to the law of the
iterated logarithm", Ann. Math. Stat. 41(5): a likelihood ratio against a mixture of alternatives
exceeds 1 / alpha at any time with a probability of at most alpha (Ville's inequality).
"""

from __future__ import annotations

import math

from scipy.optimize import brentq
from scipy.special import betaincinv, betaln, xlog1py, xlogy

from leadthrough import check

# The mixture is Jeffreys' prior of a fraction: Beta(1/2, 1/2).
_PRIOR = 0.5
_SMALLEST = 1e-15  # fraction: the bounds lie between this and 1 less this


def clopper_pearson(successes: int, runs: int, *, confidence: float = 0.95) -> tuple[float, float]:
    """Lower and upper bound of the fraction that succeeds, for a number of runs fixed before.

    Args:
        successes: number of runs that succeeded.
        runs: number of all runs, >= 1.
        confidence: probability, in (0, 1), with which the bounds hold at least.

    Raises:
        InvalidInput: if an argument is out of its range.
    """
    count, total = _counted(successes, runs)
    rest = 0.5 * (1.0 - check.number(confidence, "confidence", above=0.0, below=1.0))
    low = 0.0 if count == 0 else float(betaincinv(count, total - count + 1, rest))
    high = 1.0 if count == total else float(betaincinv(count + 1, total - count, 1.0 - rest))
    return low, high


def lower_bound(successes: int, runs: int, *, confidence: float) -> float:
    """The lower of Clopper and Pearson's bounds alone, which then is higher."""
    return clopper_pearson(successes, runs, confidence=2.0 * confidence - 1.0)[0]


def confidence_sequence(
    successes: int, runs: int, *, confidence: float = 0.95
) -> tuple[float, float]:
    """Lower and upper bound of the fraction that succeeds, valid whenever one stops to look.

    With the stated probability the bounds hold after every number of runs at once, so one may stop
    as soon as they are narrow enough.

    Args:
        successes: number of runs that succeeded until now.
        runs: number of all runs until now, >= 1.
        confidence: probability, in (0, 1), with which all bounds hold at least.

    Raises:
        InvalidInput: if an argument is out of its range.
    """
    count, total = _counted(successes, runs)
    alpha = 1.0 - check.number(confidence, "confidence", above=0.0, below=1.0)
    failures = total - count
    mixed = betaln(_PRIOR + count, _PRIOR + failures) - betaln(_PRIOR, _PRIOR)

    def excess(fraction: float) -> float:
        """Of the logarithm of the likelihood ratio over that of 1 / alpha."""
        single = xlogy(count, fraction) + xlog1py(failures, -fraction)
        return float(mixed - single + math.log(alpha))

    best = count / total
    low = high = best
    if count > 0:
        low = float(brentq(excess, _SMALLEST, best)) if excess(_SMALLEST) > 0.0 else 0.0
    if failures > 0:
        top = 1.0 - _SMALLEST
        high = float(brentq(excess, best, top)) if excess(top) > 0.0 else 1.0
    return low, high


def _counted(successes: int, runs: int) -> tuple[int, int]:
    total = check.integer(runs, "runs", at_least=1)
    return check.integer(successes, "successes", at_least=0, at_most=total), total
