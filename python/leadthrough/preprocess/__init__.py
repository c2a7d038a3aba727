"""Turns recordings into demonstrations that models can learn from."""

from leadthrough.preprocess.align import (
    align_by_arc_length,
    align_by_time_warping,
    dtw_distance,
    frechet_distance,
)
from leadthrough.preprocess.clean import clean, cut_at_gaps
from leadthrough.preprocess.report import CleaningReport
from leadthrough.preprocess.resample import arc_length, by_arc_length, sample_evenly
from leadthrough.preprocess.segment import join, segment
from leadthrough.preprocess.smooth import smooth_by_spline, smooth_motion
from leadthrough.rest import trim

__all__ = [
    "CleaningReport",
    "align_by_arc_length",
    "align_by_time_warping",
    "arc_length",
    "by_arc_length",
    "clean",
    "cut_at_gaps",
    "dtw_distance",
    "frechet_distance",
    "join",
    "sample_evenly",
    "segment",
    "smooth_by_spline",
    "smooth_motion",
    "trim",
]
