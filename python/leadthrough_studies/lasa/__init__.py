"""Fast Marching Learning on the LASA handwriting set (Prados et al. 2023)."""

from leadthrough_studies.lasa.study import STUDY

__all__ = ["STUDY"]
