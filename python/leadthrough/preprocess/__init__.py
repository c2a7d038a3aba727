"""Turns recordings into demonstrations that models can learn from."""

from leadthrough.preprocess.align import (
    align_by_arc_length as align_by_arc_length,
    align_by_time_warping as align_by_time_warping,
    dtw_distance as dtw_distance,
    frechet_distance as frechet_distance,
)
from leadthrough.preprocess.clean import (
    CleaningReport as CleaningReport,
    clean as clean,
    cut_at_gaps as cut_at_gaps,
)
from leadthrough.preprocess.resample import (
    arc_length as arc_length,
    by_arc_length as by_arc_length,
    sample_evenly as sample_evenly,
)
from leadthrough.preprocess.segment import join as join, segment as segment
from leadthrough.preprocess.smooth import (
    smooth_by_spline as smooth_by_spline,
    smooth_motion as smooth_motion,
)
from leadthrough.rest import trim as trim
