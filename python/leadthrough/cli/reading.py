"""Recordings and motions from the files that a command line names, and the files to write."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import leadthrough as lt
from leadthrough.cli import output
from leadthrough.cli.options import RestOptions
from leadthrough.io import reading as files
from leadthrough.io.files import replacing
from leadthrough.io.table import Ranges, Request, Table
from leadthrough.models import archive
from leadthrough.motion import Motion, thin
from leadthrough.rest import rest_at_ends

listed, can_read, blaming = files.listed, files.can_read, files.blaming

_REPORTED = 0.1  # s; shorter rests are left out silently
_EACH = 8  # recordings that are reported one by one

SKILL, TABLE = ".npz", ".csv"  # suffixes
# Of the table of faults.
_COLUMNS = (
    *("episode", "used", "samples", "left", "duration_s", "faults", "missing", "spikes"),
    *("unordered", "repeated", "flipped", "unnormalised", "longest_gap_s", "problem"),
)


_Clean = Callable[[lt.io.Recording], tuple[lt.Demonstration, lt.preprocess.CleaningReport]]


def cleaned(files: Sequence[Path], **how: Any) -> list[lt.Demonstration]:
    """The recordings in files, cleaned; stderr reports the samples that were removed."""
    demonstrations = []
    recordings = lt.io.read_recordings(files, **how)
    for recording in recordings:
        # Both ends stay: `trimmed` has the options for them.
        words = {"longest_gap": "`leadthrough clean --longest-gap`", "recording": recording.name}
        with output.naming(**words):
            demonstration, report = lt.preprocess.clean(recording, rest=math.inf)
        print(f"{recording.name}: {report}", file=sys.stderr)
        demonstrations.append(demonstration)
    return demonstrations


def cut(
    recordings: Sequence[lt.Demonstration], resting: RestOptions, *, pause: float | None
) -> list[lt.Demonstration]:
    """The motions between the recordings' pauses, listed on stderr."""
    shortest: dict[str, Any] = {} if pause is None else {"pause": pause}
    motions = [
        motion
        for recording in recordings
        for motion in lt.preprocess.segment(
            recording, speed=resting.speed, angular_speed=resting.angular_speed, **shortest
        )
    ]
    for number, demonstration in enumerate(motions, start=1):
        first, last = demonstration.motion.times[[0, -1]]
        print(
            f"motion {number}: {demonstration.name}, {first:.2f} to {last:.2f} s", file=sys.stderr
        )
    if not motions:
        raise lt.errors.InvalidInput("--cut: found no motion in these recordings")
    return motions


def trimmed(recordings: Sequence[lt.Demonstration], resting: RestOptions) -> list[lt.Demonstration]:
    """The recordings without the rest at both ends; stderr reports how long it was."""
    kept = [lt.preprocess.trim(each, **vars(resting)) for each in recordings]
    _report_rests(recordings, kept)
    return kept


def _report_rests(recordings: Sequence[lt.Demonstration], kept: Sequence[lt.Demonstration]) -> None:
    """Prints on stderr how long each recording stood still; of many, only the longest."""
    rests = []
    for whole, demonstration in zip(recordings, kept, strict=True):
        before, after = rest_at_ends(whole.motion, demonstration.motion)
        if max(before, after) > _REPORTED:
            rests.append((whole.name, before, after))
    said = [
        f"{name}: stood still, left out {before:.2f} s before, {after:.2f} s after (--rest)"
        for name, before, after in rests
    ]
    if len(rests) > _EACH:
        longest = max(before + after for _, before, after in rests)
        said = [
            f"{len(rests)} recordings: stood still, left out up to {longest:.2f} s of each (--rest)"
        ]
    for line in said:
        print(line, file=sys.stderr)


def one_motion(file: Path, *, joints: Ranges | None = None) -> Motion:
    refuse_skills([file])
    return lt.io.read_motion(file, joints=joints)


def first_table(file: Path, request: Request) -> Table:
    with blaming(file):
        return lt.io.formats.of_file(file).tables(file, request)[0]


def saved_skill(file: Path) -> lt.models.Skill:
    if not file.is_file():
        raise lt.errors.InvalidInput(f"{file}: no such file")
    if file.suffix.lower() != SKILL:
        raise lt.errors.InvalidInput(
            f"{file}: expected a skill, a {SKILL} that `leadthrough learn` wrote, "
            f"got {file.suffix or 'a file without a suffix'}"
        )
    with output.naming(path=str(file)):
        return lt.load_skill(file)


def refuse_skills(files: Sequence[Path]) -> None:
    for file in files:
        if file.suffix.lower() == SKILL and file.is_file() and _is_skill(file):
            raise lt.errors.InvalidInput(
                f"{file}: expected recordings or a motion, got a skill; `leadthrough plan {file}` "
                "makes a motion of it"
            )


def check_suffix(path: Path, suffix: str, option: str) -> None:
    """Refuses a file's name with another suffix, before anything is computed."""
    if path.suffix.lower() != suffix:
        raise lt.errors.InvalidInput(f"{option}: expected a name that ends in {suffix}, got {path}")


def _is_skill(file: Path) -> bool:
    try:
        archive.read(file)
    except lt.errors.InvalidInput:
        return False
    return True


def check_output(out: Path, format: str | None = None) -> None:
    """Refuses a file that no motion can be written to, before anything is computed."""
    with output.naming(path="--out"):
        lt.io.formats.to_write(out, format)


def write_motion(motion: Motion, out: Path, format: str | None) -> None:
    """Writes a motion to the file of --out."""
    with output.naming(path="--out", trajectory=f"--out {out}", motion=f"--out {out}"):
        lt.io.write_motion(motion, out, format=format)


def streamed(
    recordings: Sequence[Path], how: dict[str, Any], table: Path, samples: int
) -> list[lt.Demonstration]:
    """The recordings that can be cleaned, each thinned out as it comes, with a table of faults."""
    check_suffix(table, TABLE, "--table")
    episodes = lt.io.stream_recordings(recordings, **how)
    return [
        replace(demonstration, motion=thin(demonstration.motion, samples))
        for _, demonstration, _ in cleaned_episodes(episodes, lt.preprocess.clean, table)
    ]


def cleaned_episodes(
    episodes: Iterable[lt.io.Episode], clean: _Clean, table: Path
) -> Iterator[tuple[int, lt.Demonstration, lt.preprocess.CleaningReport]]:
    """The episodes that can be cleaned, one after the other, with their numbers, counted from 1."""
    used, problem = 0, "--table: there are no episodes"
    with replacing(table) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, _COLUMNS, restval="", lineterminator="\n")
        writer.writeheader()
        for number, episode in enumerate(episodes, start=1):
            found = None
            problem = episode.problem
            if episode.recording is not None:
                try:
                    found = clean(episode.recording)
                except lt.errors.InvalidInput as error:
                    problem = f"{episode.name}: {error}"
            writer.writerow(_row(episode.name, found, problem))
            if found is not None:
                used += 1
                yield number, *found
    if not used:
        raise lt.errors.InvalidInput(problem)


def _row(
    name: str, found: tuple[lt.Demonstration, lt.preprocess.CleaningReport] | None, problem: str
) -> dict[str, object]:
    if found is None:
        return {"episode": name, "used": "no", "problem": problem}
    demonstration, report = found
    return {
        "episode": name,
        "used": "yes",
        "samples": report.read,
        "left": report.left,
        "duration_s": round(demonstration.motion.duration, 6),
        "faults": report.faults,
        "missing": len(report.invalid),
        "spikes": len(report.spikes),
        "unordered": report.unordered,
        "repeated": report.repeated,
        "flipped": report.flipped,
        "unnormalised": report.unnormalised,
        "longest_gap_s": round(max((end - start for start, end in report.gaps), default=0.0), 6),
    }
