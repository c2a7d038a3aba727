"""Turns recordings into what models learn from."""

from leadthrough.preprocess.align import align_by_arc_length, align_by_time_warping
from leadthrough.preprocess.join import join
from leadthrough.preprocess.segment import segment

__all__ = ["align_by_arc_length", "align_by_time_warping", "join", "segment"]
