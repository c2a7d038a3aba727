"""The studies by name."""

from leadthrough_studies.agriculture import study as agriculture_study
from leadthrough_studies.human import study as human_study
from leadthrough_studies.lasa import study as lasa_study
from leadthrough_studies.singularity import study as singularity_study
from leadthrough_studies.study import Study
from leadthrough_studies.trajectories import study as trajectories_study
from leadthrough_studies.ur3 import study as ur3_study

STUDIES: dict[str, Study] = {
    "agriculture": agriculture_study.STUDY,
    "human": human_study.STUDY,
    "lasa": lasa_study.STUDY,
    "singularity": singularity_study.STUDY,
    "trajectories": trajectories_study.STUDY,
    "ur3": ur3_study.STUDY,
}
