"""The studies by name."""

from leadthrough.experiments import lasa_study
from leadthrough.experiments.study import Study

STUDIES: dict[str, Study] = {"lasa": lasa_study.STUDY}
