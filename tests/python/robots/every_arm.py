"""Arms of two packages, each from its URDF and two recordings to a simulated and exported motion.

`./do arms [NAME ...]` takes all arms of arms.toml, or those whose names contain one of the words,
and writes the table of docs/guide/arms.md if it takes all.
"""

import json
import re
import sys
import tempfile
import time
import tomllib
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cli.command_line import RUNNER, write_table
from foreign_arms import urdf_in_package
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import cli

LIST = Path(__file__).with_name("arms.toml")
PAGE = Path(__file__).parents[3] / "docs" / "guide" / "arms.md"
BEGIN, END = "<!-- made by ./do arms -->", "<!-- end -->"
RATE = 50  # Hz, of the recordings
NOISE = 2e-4  # rad (m), of the encoders
PACE = 0.4  # of a joint's speed limit, at most
REACH = 0.15  # of a joint's range, and at most so many rad (m)
MAX_REACH = 0.5
HELD = 0.8  # of a joint's torque, at most, to hold the arm in a demonstration
MAX_ATTEMPTS = 4000


@dataclass(frozen=True)
class Entry:
    """A row of the list."""

    name: str
    package: str
    urdf: str
    base: str
    tip: str


@dataclass(frozen=True)
class Outcome:
    """How far an arm came, and why no farther, or what had to be assumed."""

    joints: int
    failed: str  # step, empty if none
    reason: str
    seconds: float

    @property
    def lacks(self):
        """Whether the package's files lack what the failed step needs."""
        return self.failed == "load"


def listed():
    """The arms of the list."""
    return [Entry(**row) for row in tomllib.loads(LIST.read_text())["arm"]]


def record(arm, *, seed=0):
    """Writes two recordings of a reach that is clear of the arm itself, 0.csv and 1.csv."""
    rng = np.random.default_rng(seed)
    first, way = clear_reach(arm, rng)
    speed = np.where(arm.limits.velocity > 0.0, arm.limits.velocity, 1.0)
    duration = max(2.0, float((1.875 * np.abs(way) / (PACE * speed)).max()))
    times = np.arange(0.0, duration, 1.0 / RATE)
    rise = minimum_jerk(times / times[-1])[:, None]
    for number in range(2):
        q = first + rise * way * (1.0 + 0.02 * number)
        rows = np.column_stack([times, q + rng.normal(0.0, NOISE, q.shape)])
        write_table(f"{number}.csv", ",".join(["time", *arm.joint_names]), rows)


def clear_reach(arm, rng):
    """Joints at a start and their way to a goal, inside the limits and clear of the arm itself."""
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    for attempt in range(MAX_ATTEMPTS):
        first = lower + rng.uniform(0.25, 0.75, len(lower)) * (upper - lower)
        way = rng.choice([-1.0, 1.0], len(lower)) * np.minimum(REACH * (upper - lower), MAX_REACH)
        way *= 1.0 - attempt / MAX_ATTEMPTS
        path = first + minimum_jerk(np.linspace(0.0, 1.0, 20))[:, None] * way
        motion = lt.JointTrajectory(np.arange(20.0), path)
        if holds(arm, path) and (not arm.robot.collisions or arm.check(motion).ok):
            return first, way
    raise lt.errors.FitError("no reach found that its motors hold and that is clear of itself")


def holds(arm, path):
    """Whether the arm's motors hold it along a path with some torque left; yes where unknown."""
    effort = np.where(arm.limits.effort > 0.0, arm.limits.effort, np.inf)
    try:
        torque = arm.inverse_dynamics(path, np.zeros_like(path), np.zeros_like(path))
    except lt.errors.InvalidRobot:
        return True  # no masses
    return bool((np.abs(torque) <= HELD * effort).all())


def outcome(entry, folder, *, simulated=True):
    """How far an arm comes by `leadthrough info`, `start`, `simulate` and an export."""
    begun = time.perf_counter()
    joints, failed, reason = 0, "load", ""
    with chdir(folder):
        try:
            urdf = urdf_in_package(entry.package, entry.urdf)
            arm = lt.Arm.from_urdf(urdf, base=entry.base, tip=entry.tip)
            joints = len(arm.joint_names)
            record(arm)
            failed, reason = run(entry, urdf, simulated=simulated)
        except lt.errors.LeadthroughError as error:
            reason = str(error)
    return Outcome(joints, failed, reason, time.perf_counter() - begun)


def run(entry, urdf, *, simulated):
    """The step that fails and why; empty texts if none does."""
    if code(result := invoked("info", urdf)):
        return "info", error_of(result)
    ends = ("--base", entry.base, "--tip", entry.tip)
    started = invoked("start", urdf, "0.csv", "1.csv", *ends, "--yes")
    if code(started):
        return failed_step(started)
    return after_start(error_of(started)) if simulated else ("", "")


def failed_step(started):
    """The command of `leadthrough start` that failed, and why."""
    (step,) = re.findall(r"^\$ leadthrough (\w+)", started.stdout, re.MULTILINE)[-1:] or ("start",)
    if step != "view":
        return step, error_of(started)
    # It goes on after a verdict of no.
    nearest = json.loads(invoked("check", "timed.json", "--json").stdout)["nearest_itself"]
    return "check", f"{' and '.join(nearest['bodies'])} {1e3 * nearest['distance']:.1f} mm apart"


def after_start(said):
    """The step after `start` that fails and why, with what that said of the arm's torques."""
    simulation, assumed = ("simulate", "timed.json", "--json"), ""
    result = invoked(*simulation)
    if "--density" in result.output:
        assumed = "--density 1000"
        result = invoked(*simulation, *assumed.split())
    if code(result):
        found = json.loads(result.stdout)
        why = found["error"]["message"] if "error" in found else "; ".join(found["findings"])
        return "simulate", said or why
    words = ("retime", "motion.json", "--rate", "125")
    if code(result := invoked(*words, "-o", "timed.yaml")):
        return "export", error_of(result)
    assert lt.read_motion("timed.yaml").joint_names == lt.read_motion("timed.json").joint_names
    return "", assumed


def invoked(*words):
    return RUNNER.invoke(cli.app, [str(word) for word in words])


def code(result):
    """The exit code; an exception that is none of the command line's is raised."""
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code


def error_of(result):
    """The last error that a command printed, empty if none."""
    said = [line for line in result.stderr.splitlines() if line.startswith("leadthrough: ")]
    return said[-1].removeprefix("leadthrough: ") if said else ""


def write_page(rows):
    """Writes the table between its marks on the page."""
    passed = sum(not found.failed for _, found in rows)
    lacking = sum(found.lacks for _, found in rows)
    said = f"{passed} of {len(rows)} arms pass; {lacking} others lack their meshes."
    heads = ["| arm | file, first and last link | joints | result |", "|---|---|---|---|"]
    table = [said, "", *heads]
    for entry, found in rows:
        remark = f", masses by `simulate {found.reason}`" if found.reason else ""
        result = f"{found.failed}: {_plain(found.reason)}" if found.failed else f"passes{remark}"
        links = f"`{entry.urdf}`, `{entry.base}` to `{entry.tip}`"
        table.append(f"| {entry.name} | {links} | {found.joints or ''} | {result} |")
    head, begin, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    text = "\n".join([head + begin, "", *table, "", END + rest.partition(END)[2]])
    PAGE.write_text(text, encoding="utf-8")


def _plain(reason):
    """A reason without the folders of this machine."""
    reason = reason.removeprefix("leadthrough.toml: ")
    return re.sub(r"\s*\([^()]*/[^()]*\)|(?<=[ '])/[^ ',;]*/", "", reason).replace("|", "\\|")


def main(words):
    """Takes the arms, prints how far each comes, and writes the page."""
    chosen = [entry for entry in listed() if not words or any(word in entry.name for word in words)]
    rows = []
    for entry in chosen:
        with tempfile.TemporaryDirectory() as folder:
            found = outcome(entry, folder)
        rows.append((entry, found))
        print(
            f"{entry.name}: {found.failed or 'passes'} {found.reason} ({found.seconds:.0f} s)",
            flush=True,
        )
    if not words:
        write_page(rows)
    passed = sum(not found.failed for _, found in rows)
    print(f"{passed} of {len(rows)} pass")


if __name__ == "__main__":
    main(sys.argv[1:])
