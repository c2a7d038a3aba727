"""Models that learn a motion from demonstrations."""

from leadthrough.models.dmp import DMP, DMPSkill
from leadthrough.models.fast_marching import FastMarching, FastMarchingSkill
from leadthrough.models.library import SkillLibrary
from leadthrough.models.pose_dmp import PoseDMP, PoseDMPSkill
from leadthrough.models.rhythmic_dmp import (
    RhythmicDMP,
    RhythmicDMPSkill,
    RhythmicPoseDMP,
    RhythmicPoseDMPSkill,
)
from leadthrough.models.skills import load_skill

__all__ = [
    "DMP",
    "DMPSkill",
    "FastMarching",
    "FastMarchingSkill",
    "PoseDMP",
    "PoseDMPSkill",
    "RhythmicDMP",
    "RhythmicDMPSkill",
    "RhythmicPoseDMP",
    "RhythmicPoseDMPSkill",
    "SkillLibrary",
    "load_skill",
]
