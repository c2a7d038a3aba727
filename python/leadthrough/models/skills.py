"""Reads back any skill that the package can save."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive, framed
from leadthrough.models.dmp import discrete, pose, rhythmic, rhythmic_pose
from leadthrough.models.dmp.discrete import DMPSkill
from leadthrough.models.dmp.pose_skill import PoseDMPSkill
from leadthrough.models.dmp.rhythmic import RhythmicDMPSkill
from leadthrough.models.dmp.rhythmic_pose import RhythmicPoseDMPSkill
from leadthrough.models.framed import FramedSkill
from leadthrough.models.marching import model as marching
from leadthrough.models.marching.skill import FastMarchingSkill
from leadthrough.models.mixtures import gmr, task_gmr
from leadthrough.models.mixtures.gmr_skill import GMRSkill
from leadthrough.models.mixtures.task_gmr_skill import TaskGMRSkill
from leadthrough.models.promp import model as promp
from leadthrough.models.promp.skill import ProMPSkill
from leadthrough.models.protocol import Skill


def _framed(settings: dict[str, Any], arrays: archive.Arrays) -> FramedSkill:
    """A skill in the frame of its task, with the skill inside."""
    inside = {
        name.removeprefix("skill_"): value
        for name, value in arrays.items()
        if name.startswith("skill_")
    }
    skill = _KINDS[settings["kind"]](settings["skill"], inside)
    return framed.from_archive(skill, settings, arrays)


_KINDS: dict[str, Callable[[dict[str, Any], archive.Arrays], Skill]] = {
    DMPSkill.kind: discrete.from_archive,
    FastMarchingSkill.kind: marching.from_archive,
    FramedSkill.kind: _framed,
    GMRSkill.kind: gmr.from_archive,
    PoseDMPSkill.kind: pose.from_archive,
    ProMPSkill.kind: promp.from_archive,
    RhythmicDMPSkill.kind: rhythmic.from_archive,
    RhythmicPoseDMPSkill.kind: rhythmic_pose.from_archive,
    TaskGMRSkill.kind: task_gmr.from_archive,
}


def load_skill(path: StrPath) -> Skill:
    """The skill in a file that its `save` wrote.

    It generates motions of the type that it was shown; a file does not tell a type checker which.

    Args:
        path: the file.

    Raises:
        InvalidInput: if it is no skill, is damaged, or of a newer format version.
    """
    return restored(path, *archive.read(path))


def restored(path: StrPath, kind: str, settings: dict[str, Any], arrays: archive.Arrays) -> Skill:
    """The skill that `to_archive` took apart.

    Args:
        path: the file that the parts came from, for errors.
        kind: name that files have for this kind of skill.
        settings: plain values by name.
        arrays: by name.

    Raises:
        InvalidInput: if the kind is unknown, or a part is missing or not what it should be.
    """
    if kind not in _KINDS:
        raise InvalidInput(f"path: expected a skill of {sorted(_KINDS)}, got {kind!r}")
    try:
        return _KINDS[kind](settings, arrays)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InvalidInput(f"path: {path} is damaged ({error})") from None
