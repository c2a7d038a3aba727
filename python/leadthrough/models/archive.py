"""Skills in files: NumPy archives without pickle, versioned, complete or not there at all."""

from __future__ import annotations

import copy
import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io import npz
from leadthrough.io.atomic import StrPath, replacing
from leadthrough.models.certificate import Certificate
from leadthrough.models.shown import ShownSkill

FORMAT = "leadthrough skill"
VERSION = 1
_CERTIFICATE = "certificate"

Arrays = Mapping[str, NDArray[Any]]


class Archived(ShownSkill):
    """A skill that can be written to a file as settings and arrays."""

    kind: ClassVar[str]

    @abstractmethod
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings, plain values only, and arrays of numbers that make it up."""

    @property
    def certificate(self) -> Certificate | None:
        """What a validation found of it; None if it was not validated, or changed since."""
        found: Certificate | None = vars(self).get(_CERTIFICATE)
        return found

    def certified(self, certificate: Certificate | None) -> Self:
        """The same skill with a certificate, which its file keeps too.

        Args:
            certificate: of a validation; None takes away what there is.
        """
        same = copy.copy(self)
        vars(same)[_CERTIFICATE] = certificate
        return same

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        write(path, self.kind, *self.to_archive(), certificate=self.certificate)


def write(
    path: StrPath,
    kind: str,
    settings: Mapping[str, Any],
    arrays: Arrays,
    *,
    certificate: Certificate | None = None,
) -> None:
    """Writes a skill to a file."""
    head = {"format": FORMAT, "version": VERSION, "kind": kind, "settings": dict(settings)}
    if certificate is not None:
        head[_CERTIFICATE] = certificate.to_settings()
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, head=np.array(json.dumps(head)), **dict(arrays))


def read(path: StrPath) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]]]:
    """Kind, settings and arrays of a skill in a file."""
    kind, settings, arrays, _ = read_certified(path)
    return kind, settings, arrays


def read_certified(
    path: StrPath,
) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]], Certificate | None]:
    """Kind, settings, arrays and certificate of a skill in a file."""
    with suppress(OSError):  # a name that no file can have: reading says so
        if isinstance(path, str | PathLike) and not Path(path).exists():
            raise InvalidInput(f"path: no such file: {path}")
    try:
        arrays = npz.arrays(Path(path))
        head = json.loads(str(arrays.pop("head")))
        if head["format"] != FORMAT:
            raise InvalidInput(f"format: expected {FORMAT!r}, got {head['format']!r}")
        kind, version, settings = str(head["kind"]), int(head["version"]), dict(head["settings"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InvalidInput(f"path: expected a saved skill, got {path} ({error})") from None
    if version > VERSION:
        raise InvalidInput(
            f"path: expected a skill of format version {VERSION} or earlier, got {path} of version "
            f"{version}; update leadthrough"
        )
    found = head.get(_CERTIFICATE)
    certificate = None if found is None else Certificate.from_settings(found)
    return kind, settings, arrays, certificate


def quaternions(arrays: Arrays, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """Unit quaternions of a file, as they were to the bit."""
    check.quaternions(arrays[name], name, shape=shape)
    return check.frozen(arrays[name], name, shape=shape)
