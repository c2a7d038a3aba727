from .dmp.discrete import DMP
from .dmp.rhythmic import RhythmicDMP, RhythmicDMPSkill
from .dmp.skill import DMPSkill
from .dynamical.clf_dm import CLFDM
from .dynamical.fsm_dm import FSMDM
from .dynamical.lpv_ds import LPVDS
from .dynamical.modified_ds import ModifiedDS
from .dynamical.seds import SEDS
from .dynamical.skill import DynamicalSkill
from .dynamical.stability import StabilityReport
from .dynamical.umic import UMIC
from .frame import Frame
from .framed import Framed, FramedSkill
from .framed_state import FramedState
from .gaussians.fitting import FittedMixture, choose_components, fit_mixture, trace_mixture
from .gaussians.kmeans import Clusters, kmeans
from .gaussians.mixture import Mixture
from .library import OutsideTargets, SkillLibrary
from .many import generate_all
from .marching.model import FastMarching, FastMarchingSkill
from .mixtures.gmr import GMR, GMRSkill
from .mixtures.stiffness import stiffness_profile
from .mixtures.task_gmr import TaskGMR, TaskGMRSkill
from .out_of_step import OutOfStep
from .parameters import Parameter
from .promp.combination import blend, combine
from .promp.inference import Inference, Region, infer
from .promp.model import ProMP
from .promp.skill import ProMPSkill
from .protocol import Skill
from .skills import load_skill

__all__ = [
    "CLFDM",
    "DMP",
    "FSMDM",
    "GMR",
    "LPVDS",
    "SEDS",
    "UMIC",
    "Clusters",
    "DMPSkill",
    "DynamicalSkill",
    "FastMarching",
    "FastMarchingSkill",
    "FittedMixture",
    "Frame",
    "Framed",
    "FramedSkill",
    "FramedState",
    "GMRSkill",
    "Inference",
    "Mixture",
    "ModifiedDS",
    "OutOfStep",
    "OutsideTargets",
    "Parameter",
    "ProMP",
    "ProMPSkill",
    "Region",
    "RhythmicDMP",
    "RhythmicDMPSkill",
    "Skill",
    "SkillLibrary",
    "StabilityReport",
    "TaskGMR",
    "TaskGMRSkill",
    "blend",
    "choose_components",
    "combine",
    "fit_mixture",
    "generate_all",
    "infer",
    "kmeans",
    "load_skill",
    "stiffness_profile",
    "trace_mixture",
]
