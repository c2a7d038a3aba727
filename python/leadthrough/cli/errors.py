"""Errors on the command line: one line in the words of the command line, and an exit code.

The library's errors name its arguments. A command's parameters have the same names, so that each
error can be reported in the options that were typed.
"""

from __future__ import annotations

import json
import re
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

import typer

import leadthrough as lt

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
        print(f"warning: {in_words(str(message), words)}", file=sys.stderr)

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
    # Nobody writes an underscore but to name an argument.
    return re.sub(rf"{_any_of(name for name in words if '_' in name)}\b", word, message)


def _any_of(names: Iterable[str]) -> str:
    return rf"(?<![\w-])(?P<name>{'|'.join(map(re.escape, names)) or '(?!)'})"


def ending(error: Exception, words: Mapping[str, str], *, as_json: bool) -> typer.Exit:
    """Prints an error, as a line on stderr or as JSON on stdout; how the process is to exit."""
    message = in_words(_text(error), words)
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
    """Prints an error as the only JSON object on stdout."""
    error = {"type": kind, "message": message, "argument": argument}
    print(json.dumps({"error": error}, allow_nan=False))


def _text(error: Exception) -> str:
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
