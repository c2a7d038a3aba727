"""Turns recordings into what models learn from."""

from leadthrough.preprocess.align import align_by_arc_length, align_by_time_warping
from leadthrough.preprocess.clean import clean, cut_at_gaps
from leadthrough.preprocess.join import join
from leadthrough.preprocess.report import CleaningReport
from leadthrough.preprocess.sampling import sample_evenly, smooth_by_spline, smooth_motion
from leadthrough.preprocess.segment import segment

__all__ = [
    "CleaningReport",
    "align_by_arc_length",
    "align_by_time_warping",
    "clean",
    "cut_at_gaps",
    "join",
    "sample_evenly",
    "segment",
    "smooth_by_spline",
    "smooth_motion",
]
