"""What to type next, at the end of a command."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import typer

_ARM = ("robot", "base", "tip", "limits")
_AS_THEY_ARE = ("&&",)


def hint(*words: str | Path, unless: bool) -> None:
    """Prints the next command line, quoted as a shell needs it.

    Args:
        words: of the command line.
        unless: whether a program reads the output, which needs no hint.
    """
    if not unless:
        quoted = (word if word in _AS_THEY_ARE else shlex.quote(str(word)) for word in words)
        print("next:", " ".join(quoted))


def arm(ctx: typer.Context) -> Iterator[str]:
    """The options that name the arm, as they were typed; the profile's need not be repeated.

    Args:
        ctx: of the command that is running.
    """
    for name in _ARM:
        source = ctx.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE" and ctx.params[name] is not None:
            yield from (f"--{name}", str(ctx.params[name]))
