"""Models that learn a motion from demonstrations."""

from leadthrough.models.dmp import DMP, DMPSkill
from leadthrough.models.fast_marching import FastMarching, FastMarchingSkill
from leadthrough.models.gmr import GMR
from leadthrough.models.gmr_skill import GMRSkill
from leadthrough.models.kmeans import kmeans
from leadthrough.models.library import SkillLibrary
from leadthrough.models.mixture import Mixture
from leadthrough.models.mixture_em import choose_components, fit_mixture
from leadthrough.models.pose_dmp import PoseDMP, PoseDMPSkill
from leadthrough.models.promp import ProMP
from leadthrough.models.promp_combination import blend, combine
from leadthrough.models.promp_inference import infer
from leadthrough.models.promp_skill import ProMPSkill
from leadthrough.models.rhythmic_dmp import (
    RhythmicDMP,
    RhythmicDMPSkill,
    RhythmicPoseDMP,
    RhythmicPoseDMPSkill,
)
from leadthrough.models.skills import load_skill
from leadthrough.models.stiffness import stiffness_profile
from leadthrough.models.task_frames import Frame
from leadthrough.models.task_gmr import TaskGMR, TaskGMRSkill

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
