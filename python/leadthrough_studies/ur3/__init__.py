"""Five workspace experiments of a UR3 (Prados et al. 2023)."""

from leadthrough_studies.ur3.study import STUDY

__all__ = ["STUDY"]
