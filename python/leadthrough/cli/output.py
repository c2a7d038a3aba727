"""Results and errors of a command as text or JSON, and the next command line to type.

The library's errors name its arguments. A command's parameters have the same names, so that each
error can be reported in the options that were typed.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import textwrap
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import typer
from rich import box
from rich.console import Console, Group
from rich.table import Table

import leadthrough as lt

_ARM = ("robot", "base", "tip", "limits", "mesh_folder")
GUIDED = "guided"  # the context's object where the commands follow one another
_WIDTH = 80  # characters
_WHOLE_WORDS: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}


def hint(ctx: typer.Context, *words: str | Path) -> None:
    """Prints the next command line, unless `leadthrough start` runs it by itself."""
    if ctx.find_root().obj != GUIDED:
        advise(line(ctx, *words))


def line(ctx: typer.Context, *words: str | Path) -> str:
    """A command line quoted for a shell, with --no-profile where it was set; && begins another."""
    unset = " --no-profile" if ctx.find_root().params.get("no_profile") else ""
    program = f"leadthrough{unset}"
    return " ".join(
        [program, *(f"&& {program}" if word == "&&" else quoted(word) for word in words)]
    )


def advise(text: str) -> None:
    print("next:", text)


def arm_words(ctx: typer.Context) -> tuple[str, ...]:
    """The options that name the arm, as typed; those of the profile need no repetition."""
    return typed(ctx, *_ARM)


def typed(ctx: typer.Context, *names: str) -> tuple[str, ...]:
    """Options of the command that is running, as words of a command line, where they were typed."""
    options = {each.name: each.opts[0] for each in ctx.command.params}
    given = [name for name in names if source(ctx, name) == "COMMANDLINE"]
    return tuple(word for name in given for word in _words(options[name], ctx.params[name]))


def repeated(
    ctx: typer.Context, *left_out: str, changed: tuple[str, ...]
) -> tuple[str | Path, ...]:
    """The command that is running, as typed, without some parameters and with other words."""
    names = [each.name for each in ctx.command.params if each.name is not None]
    kept = [name for name in names if name not in (*left_out, "files", "as_json")]
    return (str(ctx.command.name), *ctx.params["files"], *typed(ctx, *kept), *changed)


def words(**values: object) -> tuple[str, ...]:
    """Options as words of a command line."""
    given = {name: value for name, value in values.items() if value is not None}
    return tuple(
        word
        for name, value in given.items()
        for word in _words(f"--{name.replace('_', '-')}", value)
    )


def _words(option: str, value: Any) -> Iterator[str]:
    if value is True:  # a flag
        yield option
        return
    for each in value if isinstance(value, list | tuple) else [value]:
        # A value such as -0.1,0,0 would look like an option of its own.
        yield from [f"{option}={each}"] if str(each).startswith("-") else [option, str(each)]


def quoted(word: str | Path) -> str:
    """A word quoted for a shell; a file whose name looks like an option gets its folder."""
    looks_like_option = isinstance(word, Path) and str(word).startswith("-")
    return shlex.quote(f"./{word}" if looks_like_option else str(word))


def source(ctx: typer.Context, name: str) -> str | None:
    """Source of a parameter's value: "COMMANDLINE", "DEFAULT_MAP" (the profile), ..."""
    found = ctx.get_parameter_source(name)
    return None if found is None else found.name


def table(rows: list[dict[str, Any]]) -> Group:
    """The rows as tables of 80 columns, transposed if that is narrower."""
    names = [name.replace("_", " ") for name in rows[0]] if rows else []
    lines = [names, *([_cell(value) for value in row.values()] for row in rows)]
    if len(names) > len(lines):
        lines = [list(line) for line in zip(*lines, strict=True)]
    return Group(*(_printed(part) for part in _narrow(lines)))


def _narrow(lines: list[list[str]]) -> Iterator[list[list[str]]]:
    """The lines cut into parts whose columns fit, each part behind the first column."""
    widths = [max(map(len, column)) + 1 for column in zip(*lines, strict=True)]
    first = 1
    while first < len(widths):
        last, used = first + 1, widths[0] + widths[first] + 1
        while last < len(widths) and used + widths[last] <= _WIDTH:
            used += widths[last]
            last += 1
        yield [[line[0], *line[first:last]] for line in lines]
        first = last
    if len(widths) == 1:
        yield lines


def _printed(lines: list[list[str]]) -> Table:
    # Words break where there is no room for a column; names with underscores do not.
    printed = Table(box=box.SIMPLE, padding=0, show_header=False)
    for line in lines:
        printed.add_row(*line)
    return printed


def facts(
    found: Mapping[str, Any], *, as_json: bool, units: Mapping[str, str] = MappingProxyType({})
) -> None:
    """Prints a name and its value per line, or all as one JSON object."""
    if as_json:
        print(json.dumps(found, allow_nan=False))
        return
    width = max(map(len, found)) + 2
    for name, value in found.items():
        label = name.replace("_", " ")
        text = f"{label:<{width}}{_text(value)} {units.get(name, '')}".rstrip()
        print(textwrap.fill(text, _WIDTH, subsequent_indent=" " * width, **_WHOLE_WORDS))


def note(text: str) -> None:
    """Prints on stderr what a user may want to know of a result."""
    print(textwrap.fill(f"note: {text}", _WIDTH, **_WHOLE_WORDS), file=sys.stderr)


def warn(text: str) -> None:
    """Prints a warning on stderr, as one line."""
    print(f"warning: {text}", file=sys.stderr)


def busy(what: str) -> AbstractContextManager[Any]:
    """Shows on a terminal's stderr what is going on while the block runs."""
    return Console(stderr=True).status(what)


def _text(value: Any) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(_text, value)) or "none"
    return _cell(value)


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return "" if value is None else str(value)


_STOPPED = 130  # as shells have it for Ctrl-C
# The last words of some messages, for those who program: "; in Python, Arm.joints_of picks ...".
_IN_PYTHON = re.compile(r"[,;:]?\s+in\s+Python\b.*", re.DOTALL)
_OPTION = re.compile(r"(?:^|: )(--[a-z-]+)")


@contextmanager
def naming(**words: str) -> Iterator[None]:
    """Tells the errors of a block in words of the command line."""
    try:
        yield
    except lt.errors.LeadthroughError as error:
        error.args = (in_words(str(error), words), *error.args[1:])
        raise


@contextmanager
def interruptible() -> Iterator[None]:
    """Ends a command that is stopped by Ctrl-C with a line that says how to go on, and code 130."""
    try:
        yield
    except KeyboardInterrupt:
        print(
            "leadthrough: Interrupted. Finished results are saved; rerun the command to resume",
            file=sys.stderr,
        )
        raise typer.Exit(_STOPPED) from None


@contextmanager
def warnings_in(words: Mapping[str, str]) -> Iterator[None]:
    """Prints the library's warnings of a block on stderr, in words of the command line."""
    from leadthrough.sanity import ImplausibleInputWarning

    def show(message: Warning | str, *_: object) -> None:
        warn(in_words(str(message), words))

    with warnings.catch_warnings():
        warnings.simplefilter("always", ImplausibleInputWarning)
        warnings.showwarning = show  # type: ignore[assignment]  # it takes all the arguments
        yield


def in_words(message: str, words: Mapping[str, str]) -> str:
    """The message with the command line's words where the library names its arguments."""

    def word(found: re.Match[str]) -> str:
        said = words[found["name"]]
        value = found.groupdict().get("value")
        # An option takes its value after a blank; a parameter of a model is --set NAME=VALUE.
        return said if value is None else f"{said}{'=' if ' ' in said else ' '}{value}"

    argument = _any_of(words)
    message = _IN_PYTHON.sub("", message)
    message = re.sub(rf"(?:^|(?<=: )){argument}(?=: |\[\d+\]: )", word, message)
    message = re.sub(rf"{argument}\['(?P<value>\w+)'\]", word, message)
    message = re.sub(rf"{argument}=(?P<quote>['\"]?)(?P<value>[\w.+-]+)(?P=quote)", word, message)
    message = re.sub(rf"(?<=[ ;,]set ){argument}\b", word, message)
    # Nobody writes an underscore but to name an argument; the profile's keys have one too.
    named = _any_of(name for name in words if "_" in name)
    return re.sub(rf"(?<!\.toml: ){named}\b", word, message)


def _any_of(names: Iterable[str]) -> str:
    return rf"(?<![\w-])(?P<name>{'|'.join(map(re.escape, names)) or '(?!)'})"


def ending(error: Exception, words: Mapping[str, str], *, as_json: bool) -> typer.Exit:
    """Prints an error, as a line on stderr or as JSON on stdout; how the process is to exit."""
    message = in_words(_message(error), words)
    if as_json:
        print_json(type(error).__name__, message, _argument(error, message, words))
    else:
        print(f"leadthrough: {message}", file=sys.stderr)
    return typer.Exit(1 if _is_infeasible(error) else 2)


def _is_infeasible(error: Exception) -> bool:
    """Whether the input was valid, and no such motion was found."""
    infeasible = (
        lt.errors.SchedulerUnreachable,
        lt.errors.FitError,
        lt.errors.IkFailure,
        lt.errors.LimitsInfeasible,
        lt.errors.NoContinuousLogarithm,
        lt.errors.NoPath,
    )
    return isinstance(error, infeasible)


def print_json(kind: str, message: str, argument: str | None) -> None:
    error = {"type": kind, "message": message, "argument": argument}
    print(json.dumps({"error": error}, allow_nan=False))


def _message(error: Exception) -> str:
    if (
        isinstance(error, OSError)
        and error.strerror
        and not isinstance(error, lt.errors.LeadthroughError)
    ):
        return f"{error.filename or 'input or output'}: {error.strerror}"
    return str(error)


def _argument(error: Exception, message: str, words: Mapping[str, str]) -> str | None:
    if option := _OPTION.search(message):
        return option[1]
    named = getattr(error, "argument", None)
    return None if named is None else words.get(named.partition("[")[0], named)
