"""What to type next, at the end of a command."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

_ARM = ("robot", "base", "tip", "limits", "mesh_folder")
_READING = ("column", "rate", "angles", "quaternions", "topic")
_OPERATORS = ("&&",)
_PROGRAM = "leadthrough"


def hint(ctx: typer.Context, *words: str | Path) -> None:
    """Prints the next command line, quoted for a shell, with --no-profile where it was set."""
    program = f"{_PROGRAM} --no-profile" if ctx.find_root().params.get("no_profile") else _PROGRAM
    kept = {word: word for word in _OPERATORS} | {_PROGRAM: program}
    advise(" ".join(kept.get(str(word)) or shlex.quote(_word(word)) for word in words))


def advise(text: str) -> None:
    """Prints what to do next."""
    print("next:", text)


def arm(ctx: typer.Context) -> tuple[str, ...]:
    """The options that name the arm, as they were typed; those of the profile need no repetition.

    Args:
        ctx: of the command that is running.
    """
    return typed(ctx, *_ARM)


def reading(ctx: typer.Context) -> tuple[str, ...]:
    """The options that say how recordings are read, as they were typed."""
    return typed(ctx, *_READING)


def typed(ctx: typer.Context, *names: str) -> tuple[str, ...]:
    """Options of the command that is running, as words of a command line, where they were typed."""
    options = {each.name: each.opts[0] for each in ctx.command.params}
    given = [name for name in names if _is_typed(ctx, name)]
    return tuple(word for name in given for word in _words(options[name], ctx.params[name]))


def options(**values: str | Path | None) -> tuple[str, ...]:
    """Options as words of a command line."""
    given = {name: value for name, value in values.items() if value is not None}
    return tuple(
        word
        for name, value in given.items()
        for word in _words(f"--{name.replace('_', '-')}", value)
    )


def _words(option: str, value: Any) -> Iterator[str]:
    if value is True:
        yield option
        return
    if value is True:  # a flag
        yield option
        return
    for each in value if isinstance(value, list | tuple) else [value]:
        # A value such as -0.1,0,0 would look like an option of its own.
        yield from [f"{option}={each}"] if str(each).startswith("-") else [option, str(each)]


def _word(word: str | Path) -> str:
    """A word of a command line; a file whose name looks like an option gets its folder."""
    return f"./{word}" if isinstance(word, Path) and str(word).startswith("-") else str(word)


def _is_typed(ctx: typer.Context, name: str) -> bool:
    source = ctx.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"
