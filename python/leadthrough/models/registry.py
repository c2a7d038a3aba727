"""The models, one row each: read by the command line, by loading and by the comparison study.

A package of its own adds a model by an entry point of the group `leadthrough.models`, whose object
is a `ModelEntry`. Models are imported when they are first used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from leadthrough.check import InvalidInput
    from leadthrough.models.protocol import Skill

GROUP = "leadthrough.models"


@dataclass(frozen=True)
class ModelEntry:
    """A model: its definition, its types of motion, and the kinds of its skills in files.

    Attributes:
        name: its name for the command line; of an entry point, the same name.
        model: "module:Class" of its settings, imported when first used.
        skills: names of its skills in files (`Skill.kind`), today's first.
        motions: that it learns, of "points", "joints" and "poses".
        otherwise: models for other motions, to complete "use ..." in a message.
        restore: "module:function" that takes settings and arrays of a file and returns the skill;
            by default `from_archive` beside the model.
    """

    name: str
    model: str
    skills: tuple[str, ...]
    motions: tuple[str, ...] = ("points", "joints", "poses")
    otherwise: str = ""
    restore: str = ""

    def load(self) -> Any:
        """The class of the model's settings; no other family is imported."""
        return _imported(self.model)

    def restored(self, settings: dict[str, Any], arrays: Mapping[str, Any]) -> Skill:
        """The skill restored from its archive.

        Args:
            settings: plain values, as JSON holds them.
            arrays: arrays by name.
        """
        restore = _imported(self.restore or f"{self.model.partition(':')[0]}:from_archive")
        skill: Skill = restore(settings, arrays)
        return skill


def _system(name: str, model: str) -> ModelEntry:
    folder = "leadthrough.models.dynamical"
    return ModelEntry(
        name, f"{folder}.{model}", ("dynamical",), restore=f"{folder}.skill:from_archive"
    )


MODELS = (
    ModelEntry("dmp", "leadthrough.models.dmp.discrete:DMP", ("dmp", "pose_dmp")),
    ModelEntry("aligned-mean", "leadthrough.models.aligned.model:AlignedMean", ("aligned_mean",)),
    ModelEntry("promp", "leadthrough.models.promp.model:ProMP", ("promp",)),
    ModelEntry("gmr", "leadthrough.models.mixtures.gmr:GMR", ("gmr",)),
    ModelEntry("task-gmr", "leadthrough.models.mixtures.task_gmr:TaskGMR", ("task_gmr",)),
    ModelEntry(
        "fast-marching",
        "leadthrough.models.marching.model:FastMarching",
        ("fast_marching",),
        ("points", "poses"),
        "promp, or --robot to learn poses",
    ),
    ModelEntry(
        "rhythmic-dmp",
        "leadthrough.models.dmp.rhythmic:RhythmicDMP",
        ("rhythmic_dmp", "rhythmic_pose_dmp"),
    ),
    _system("seds", "seds:SEDS"),
    _system("lpv-ds", "lpv_ds:LPVDS"),
    _system("clf-dm", "clf_dm:CLFDM"),
    _system("modified-ds", "modified_ds:ModifiedDS"),
)
# Skills around another one; the command line does not make them.
_AROUND = (
    ModelEntry("framed", "leadthrough.models.framed:Framed", ("framed",)),
    ModelEntry("corrected", "leadthrough.models.corrected:CorrectedSkill", ("corrected",)),
)


def model_names() -> tuple[str, ...]:
    """Names of all models, those of other packages last."""
    return (*(each.name for each in MODELS), *_others())


def model_entry(name: str) -> ModelEntry:
    """The row of a model.

    Args:
        name: one of `model_names()`.

    Raises:
        InvalidInput: if there is no such model, or its package cannot be imported.
    """
    for each in MODELS:
        if each.name == name:
            return each
    if name not in _others():
        raise _invalid(f"name: expected one of {', '.join(model_names())}, got {name!r}")
    try:
        entry: ModelEntry = _others()[name].load()
    except (ImportError, AttributeError) as error:
        raise _invalid(f"name: {name}: its package cannot be imported ({error})") from error
    return entry


def entry_of_class(name: str) -> ModelEntry:
    """The row of the model whose class has a name."""
    for each in _entries():
        if each.model.partition(":")[2] == name:
            return each
    raise _invalid(f"model: {name} is not among {', '.join(model_names())}")


def entry_of_skill(kind: str) -> ModelEntry:
    """The row of the model whose skills files call by a name; of several, the first."""
    known: set[str] = set()
    for each in (*_AROUND, *_entries()):
        if kind in each.skills:
            return each
        known.update(each.skills)
    raise _invalid(f"path: expected a skill of {sorted(known)}, got {kind!r}")


def _entries() -> Iterator[ModelEntry]:
    """All rows; packages that cannot be imported are left out, for a file of another."""
    yield from MODELS
    for point in _others().values():
        try:
            entry: ModelEntry = point.load()
        except (ImportError, AttributeError):
            continue
        yield entry


@cache
def _others() -> dict[str, metadata.EntryPoint]:
    """Entry points of other packages; a name of our own is not replaced."""
    own = {each.name for each in MODELS}
    points = metadata.entry_points(group=GROUP)
    return {each.name: each for each in points if each.name not in own}


def _imported(path: str) -> Any:
    """The object at "module:name"."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)


def _invalid(message: str) -> InvalidInput:
    """The error of a name; imported here, as NumPy comes with it and --help does without."""
    from leadthrough.check import InvalidInput

    return InvalidInput(message)
