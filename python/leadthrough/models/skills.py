"""Reads back any skill that the package can save."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.protocol import Skill

# The modules that put skills of each kind together again, imported when one of that kind is read.
_KINDS = {
    "dmp": "dmp.discrete",
    "dynamical": "dynamical.saved",
    "fast_marching": "marching.model",
    "framed": "framed",
    "gmr": "mixtures.gmr",
    "pose_dmp": "dmp.discrete",
    "promp": "promp.model",
    "rhythmic_dmp": "dmp.rhythmic",
    "rhythmic_pose_dmp": "dmp.rhythmic",
    "task_gmr": "mixtures.task_gmr",
}


def load_skill(path: StrPath) -> Skill:
    """The skill in a file that its `save` wrote.

    It generates motions of the type that it was shown; a file does not tell a type checker which.

    Args:
        path: the file.

    Raises:
        InvalidInput: if it is no skill, is damaged, or of a newer format version.
    """
    kind, settings, arrays, certificate = archive.read_certified(path)
    skill = restored(path, kind, settings, arrays)
    return skill if certificate is None else skill.certified(certificate)


def restored(path: StrPath, kind: str, settings: dict[str, Any], arrays: archive.Arrays) -> Skill:
    """The skill that `to_archive` took apart."""
    if kind not in _KINDS:
        raise InvalidInput(f"path: expected a skill of {sorted(_KINDS)}, got {kind!r}")
    try:
        return _put_together(kind, settings, arrays)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InvalidInput(f"path: {path} is damaged ({error})") from None


def _put_together(kind: str, settings: dict[str, Any], arrays: archive.Arrays) -> Skill:
    module = import_module(f"leadthrough.models.{_KINDS[kind]}")
    if kind != "framed":
        from_archive: Callable[[dict[str, Any], archive.Arrays], Skill] = module.from_archive
        return from_archive(settings, arrays)
    inside = {
        name.removeprefix("skill_"): value
        for name, value in arrays.items()
        if name.startswith("skill_")
    }
    skill = _put_together(settings["kind"], settings["skill"], inside)
    framed: Skill = module.from_archive(skill, settings, arrays)
    return framed
