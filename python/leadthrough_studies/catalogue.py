"""The studies by name."""

from leadthrough_studies import (
    agriculture,
    augmentation,
    chunks,
    comparison,
    connection,
    elbow,
    human,
    lasa,
    robotasks,
    simulation,
    singularity,
    trajectories,
    ur3,
)
from leadthrough_studies.study import Study

STUDIES: dict[str, Study] = {
    "agriculture": agriculture.STUDY,
    "augmentation": augmentation.STUDY,
    "chunks": chunks.STUDY,
    "comparison": comparison.STUDY,
    "connection": connection.STUDY,
    "elbow": elbow.STUDY,
    "human": human.STUDY,
    "lasa": lasa.STUDY,
    "robotasks": robotasks.STUDY,
    "simulation": simulation.STUDY,
    "singularity": singularity.STUDY,
    "trajectories": trajectories.STUDY,
    "ur3": ur3.STUDY,
}
