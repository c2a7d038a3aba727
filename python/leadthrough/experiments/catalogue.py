"""The studies by name."""

from leadthrough.experiments import (
    agriculture_study,
    human_study,
    lasa_study,
    singularity_study,
    trajectories_study,
    ur3_study,
)
from leadthrough.experiments.study import Study

STUDIES: dict[str, Study] = {
    "agriculture": agriculture_study.STUDY,
    "human": human_study.STUDY,
    "lasa": lasa_study.STUDY,
    "singularity": singularity_study.STUDY,
    "trajectories": trajectories_study.STUDY,
    "ur3": ur3_study.STUDY,
}
