"""What to type next, at the end of a command."""

from __future__ import annotations

import shlex
from pathlib import Path

import typer

_ARM = ("robot", "base", "tip", "limits")
_OPERATORS = ("&&",)


def hint(*words: str | Path) -> None:
    """Prints the next command line, quoted as a shell needs it.

    Args:
        words: of the command line.
    """
    advise(" ".join(word if word in _OPERATORS else shlex.quote(str(word)) for word in words))


def advise(text: str) -> None:
    """Prints what to do next.

    Args:
        text: a command line, or words where none can be named.
    """
    print("next:", text)


def arm(ctx: typer.Context) -> tuple[str, ...]:
    """The options that name the arm, as they were typed; those of the profile need no repetition.

    Args:
        ctx: of the command that is running.
    """
    typed = {name: ctx.params[name] for name in _ARM if _is_typed(ctx, name)}
    return options(**typed)


def options(**values: str | Path | None) -> tuple[str, ...]:
    """Options as words of a command line.

    Args:
        values: by the options' names; those that are None are left out.
    """
    given = {name: value for name, value in values.items() if value is not None}
    return tuple(
        word
        for name, value in given.items()
        for word in (f"--{name.replace('_', '-')}", str(value))
    )


def _is_typed(ctx: typer.Context, name: str) -> bool:
    source = ctx.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
