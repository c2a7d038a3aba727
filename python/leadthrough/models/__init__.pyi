from .aligned.model import AlignedMean as AlignedMean, AlignedMeanSkill as AlignedMeanSkill
from .archive import FittedSkill as FittedSkill, load_skill as load_skill
from .certificate import (
    Certificate as Certificate,
    ConfidenceInterval as ConfidenceInterval,
    Target as Target,
    TargetRegion as TargetRegion,
    ValidatedScene as ValidatedScene,
)
from .corrected import CorrectedSkill as CorrectedSkill, Correction as Correction
from .dmp.discrete import DMP as DMP, DMPSkill as DMPSkill
from .dmp.rhythmic import RhythmicDMP as RhythmicDMP, RhythmicDMPSkill as RhythmicDMPSkill
from .dynamical.clf_dm import CLFDM as CLFDM
from .dynamical.field import StabilityReport as StabilityReport
from .dynamical.lpv_ds import LPVDS as LPVDS
from .dynamical.modified_ds import ModifiedDS as ModifiedDS
from .dynamical.seds import SEDS as SEDS
from .dynamical.skill import DynamicalSkill as DynamicalSkill
from .framed import (
    Frame as Frame,
    Framed as Framed,
    FramedSkill as FramedSkill,
    FramedState as FramedState,
)
from .gaussians.fitting import (
    FittedMixture as FittedMixture,
    choose_components as choose_components,
    fit_mixture as fit_mixture,
    trace_mixture as trace_mixture,
)
from .gaussians.kmeans import Clusters as Clusters, kmeans as kmeans
from .gaussians.mixture import Mixture as Mixture
from .learn import Reproduction as Reproduction, learn as learn, reproduction as reproduction
from .library import OutsideTargets as OutsideTargets, SkillLibrary as SkillLibrary
from .marching.model import FastMarching as FastMarching, FastMarchingSkill as FastMarchingSkill
from .mixtures.gmr import GMR as GMR, GMRSkill as GMRSkill
from .mixtures.stiffness import stiffness_profile as stiffness_profile
from .mixtures.task_gmr import TaskGMR as TaskGMR, TaskGMRSkill as TaskGMRSkill
from .promp.combination import blend as blend, combine as combine
from .promp.inference import Inference as Inference, Region as Region, infer as infer
from .promp.model import ProMP as ProMP, ProMPSkill as ProMPSkill
from .protocol import (
    Choice as Choice,
    MisalignmentWarning as MisalignmentWarning,
    Model as Model,
    Parameter as Parameter,
    Skill as Skill,
)
from .queries import generate_all as generate_all
from .registry import (
    ModelEntry as ModelEntry,
    model_entry as model_entry,
    model_names as model_names,
)
