"""The command line: each command parses, calls the library and prints."""

from __future__ import annotations

from typing import Annotated

import typer

from leadthrough.cli.command import PROFILE, Command, Commands
from leadthrough.cli.learn import learn
from leadthrough.cli.motions import check, guard, retime, simulate
from leadthrough.cli.options import flattened
from leadthrough.cli.plan import plan
from leadthrough.cli.recordings import clean, info, judge
from leadthrough.cli.showing import demo, example, teach, view
from leadthrough.cli.start import start
from leadthrough.cli.sweeps import augment, experiment, reach, validate

__all__ = ["app", "main"]

_ENDINGS = (
    "Exit codes: 0 success; 1 check failed or infeasible (a limit exceeded, a collision, no path, "
    "no joint positions that reach the goal, a study with failures); 2 wrong input or usage; 130 "
    "interrupted by Ctrl-C. "
    f"The options --robot, --base, --tip and --limits may stand in a file {PROFILE} instead."
)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"leadthrough {version('leadthrough')}")
        raise typer.Exit


app = typer.Typer(
    cls=Commands, no_args_is_help=True, pretty_exceptions_enable=False, epilog=_ENDINGS
)
for each in (
    demo,
    start,
    teach,
    example,
    info,
    clean,
    judge,
    learn,
    plan,
    retime,
    check,
    guard,
    simulate,
    validate,
    augment,
    reach,
    view,
    experiment,
):
    app.command(cls=Command)(flattened(each))


@app.callback()
def leadthrough(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
    no_profile: Annotated[
        bool, typer.Option("--no-profile", help=f"Ignore the file {PROFILE} in this folder.")
    ] = False,
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Hand-guided demonstrations in, executable robot-arm motion out."""


def main() -> None:
    """Runs the command line and exits the process with the command's exit code."""
    app()
