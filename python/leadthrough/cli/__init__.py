"""The command line: each command parses, calls the library and prints."""

from __future__ import annotations

from typing import Annotated

import typer

from leadthrough.cli.check import check
from leadthrough.cli.clean import clean
from leadthrough.cli.command import Command, Commands
from leadthrough.cli.demo import demo
from leadthrough.cli.example import example
from leadthrough.cli.experiment import experiment
from leadthrough.cli.guard import guard
from leadthrough.cli.info import info
from leadthrough.cli.judge import judge
from leadthrough.cli.learn import learn
from leadthrough.cli.plan import plan
from leadthrough.cli.profile import FILE
from leadthrough.cli.reach import reach
from leadthrough.cli.retime import retime
from leadthrough.cli.simulate import simulate
from leadthrough.cli.validate import validate
from leadthrough.cli.view import view

__all__ = ["app", "main"]

_ENDINGS = (
    "Exit codes: 0 success; 1 the answer is no (a limit exceeded, a collision, no path, no joint "
    "positions that reach the goal, a study with failures); 2 wrong input or usage; 130 stopped by "
    "Ctrl-C. "
    f"The options --robot, --base, --tip and --limits may stand in a file {FILE} instead."
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
    reach,
    view,
    experiment,
):
    app.command(cls=Command)(each)


@app.callback()
def leadthrough(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
    no_profile: Annotated[
        bool, typer.Option("--no-profile", help=f"Ignore the file {FILE} in this folder.")
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
