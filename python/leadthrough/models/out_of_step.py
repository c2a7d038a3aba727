"""A warning of demonstrations that show the same at other times, which a mean would blur."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough import plausible
from leadthrough.motion import Motion
from leadthrough.preprocess.align import lateness

# Of the largest time that one is ahead or behind; those below are not named.
_NAMED = 0.6


class OutOfStep(UserWarning):
    """Demonstrations are out of step: the message names them, and what to do."""


def warn_of_others_timing(motions: Sequence[Motion]) -> None:
    """Warns where a fit blurs what demonstrations show at different times."""
    late = lateness(motions)
    if not late.any():
        return
    named = [i for i, each in enumerate(late) if each >= _NAMED * late.max()]
    plausible.warn(
        f"demonstrations {named}: out of step, up to {late.max():.0%} of the duration ahead of "
        "or behind the mean timing of all, so that the fit blurs what they show; bring them into "
        "step with preprocess.align_by_time_warping, or leave them out",
        OutOfStep,
    )
