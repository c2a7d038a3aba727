"""Recordings and motions from the files that a command line names."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from leadthrough import io, preprocess
from leadthrough.errors import InvalidInput
from leadthrough.motion import Demonstration, Motion


def cleaned(files: Sequence[Path], **request: Any) -> list[Demonstration]:
    """The recordings in files without their faults, which stderr tells.

    request: as `read_demonstrations` takes it. Raises InvalidInput, MissingDependency.
    """
    demonstrations = []
    for recording in io.read_recordings(files, **request):
        demonstration, report = preprocess.clean(recording)
        print(f"{recording.name}: {report}", file=sys.stderr)
        demonstrations.append(demonstration)
    return demonstrations


def cut(recordings: Sequence[Demonstration]) -> list[Demonstration]:
    """The motions between the recordings' pauses, listed on stderr. Raises InvalidInput."""
    motions = [motion for recording in recordings for motion in preprocess.segment(recording)]
    for number, shown in enumerate(motions, start=1):
        first, last = shown.motion.times[[0, -1]]
        print(f"motion {number}: {shown.name}, {first:.2f} to {last:.2f} s", file=sys.stderr)
    if not motions:
        raise InvalidInput("--cut: nothing moves in these recordings")
    return motions


def one_motion(file: Path) -> Motion:
    """The only motion in a file. Raises InvalidInput, MissingDependency."""
    found = io.read_demonstrations(file)
    if len(found) != 1:
        raise InvalidInput(f"{file}: expected one motion, got {len(found)}")
    return found[0].motion
