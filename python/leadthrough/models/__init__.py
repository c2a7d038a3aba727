"""Models that learn a motion from demonstrations."""

from leadthrough.models.dmp.discrete import DMP, DMPSkill
from leadthrough.models.dmp.pose import PoseDMP, PoseDMPSkill
from leadthrough.models.dmp.rhythmic import (
    RhythmicDMP,
    RhythmicDMPSkill,
    RhythmicPoseDMP,
    RhythmicPoseDMPSkill,
)
from leadthrough.models.library import SkillLibrary
from leadthrough.models.marching.model import FastMarching, FastMarchingSkill
from leadthrough.models.mixtures.em import choose_components, fit_mixture
from leadthrough.models.mixtures.gmr import GMR
from leadthrough.models.mixtures.gmr_skill import GMRSkill
from leadthrough.models.mixtures.kmeans import kmeans
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.stiffness import stiffness_profile
from leadthrough.models.mixtures.task_frames import Frame
from leadthrough.models.mixtures.task_gmr import TaskGMR, TaskGMRSkill
from leadthrough.models.promp.combination import blend, combine
from leadthrough.models.promp.inference import infer
from leadthrough.models.promp.model import ProMP
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.models.skills import load_skill

__all__ = [
    "DMP",
    "GMR",
    "DMPSkill",
    "FastMarching",
    "FastMarchingSkill",
    "Frame",
    "GMRSkill",
    "Mixture",
    "PoseDMP",
    "PoseDMPSkill",
    "ProMP",
    "ProMPSkill",
    "RhythmicDMP",
    "RhythmicDMPSkill",
    "RhythmicPoseDMP",
    "RhythmicPoseDMPSkill",
    "SkillLibrary",
    "TaskGMR",
    "TaskGMRSkill",
    "blend",
    "choose_components",
    "combine",
    "fit_mixture",
    "infer",
    "kmeans",
    "load_skill",
    "stiffness_profile",
]
