from .aligned.model import AlignedMean, AlignedMeanSkill
from .archive import FittedSkill, load_skill
from .certificate import Certificate, ConfidenceInterval
from .choice import Choice
from .demonstrations import MisalignmentWarning
from .dmp.discrete import DMP, DMPSkill
from .dmp.rhythmic import RhythmicDMP, RhythmicDMPSkill
from .dynamical.clf_dm import CLFDM
from .dynamical.field import StabilityReport
from .dynamical.lpv_ds import LPVDS
from .dynamical.modified_ds import ModifiedDS
from .dynamical.seds import SEDS
from .dynamical.skill import DynamicalSkill
from .frame import Frame
from .framed import Framed, FramedSkill, FramedState
from .gaussians.fitting import FittedMixture, choose_components, fit_mixture, trace_mixture
from .gaussians.kmeans import Clusters, kmeans
from .gaussians.mixture import Mixture
from .learn import learn
from .library import OutsideTargets, SkillLibrary
from .marching.model import FastMarching, FastMarchingSkill
from .mixtures.gmr import GMR, GMRSkill
from .mixtures.stiffness import stiffness_profile
from .mixtures.task_gmr import TaskGMR, TaskGMRSkill
from .promp.combination import blend, combine
from .promp.inference import Inference, Region, infer
from .promp.model import ProMP, ProMPSkill
from .protocol import Model, Parameter, Skill
from .queries import generate_all
from .registry import ModelEntry, model_entry, model_names
from .targets import Target, TargetRegion

__all__ = [
    "CLFDM",
    "DMP",
    "GMR",
    "LPVDS",
    "SEDS",
    "AlignedMean",
    "AlignedMeanSkill",
    "Certificate",
    "Choice",
    "Clusters",
    "ConfidenceInterval",
    "DMPSkill",
    "DynamicalSkill",
    "FastMarching",
    "FastMarchingSkill",
    "FittedMixture",
    "FittedSkill",
    "Frame",
    "Framed",
    "FramedSkill",
    "FramedState",
    "GMRSkill",
    "Inference",
    "MisalignmentWarning",
    "Mixture",
    "Model",
    "ModelEntry",
    "ModifiedDS",
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
    "Target",
    "TargetRegion",
    "TaskGMR",
    "TaskGMRSkill",
    "blend",
    "choose_components",
    "combine",
    "fit_mixture",
    "generate_all",
    "infer",
    "kmeans",
    "learn",
    "load_skill",
    "model_entry",
    "model_names",
    "stiffness_profile",
    "trace_mixture",
]
