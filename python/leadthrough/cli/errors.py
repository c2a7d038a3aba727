"""Errors on the command line: one line in the words of the command line, and an exit code."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from typing import Any

import typer
from typer.core import TyperGroup

from leadthrough.errors import (
    FitError,
    IkFailure,
    LeadthroughError,
    LimitsInfeasible,
    NoContinuousLogarithm,
    NoPath,
)

# The input was right, and there is no such motion.
_NO = (FitError, IkFailure, LimitsInfeasible, NoContinuousLogarithm, NoPath)


class Commands(TyperGroup):
    """Commands whose expected errors are one line on stderr, with a traceback only for --debug."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # a reader such as `head` has seen enough
            raise
        except (LeadthroughError, OSError) as error:
            if ctx.params.get("debug"):
                raise
            command = self.get_command(ctx, ctx.invoked_subcommand or "")
            text = _in_options(str(error), command.params if command else ())
            print(f"leadthrough: {text}", file=sys.stderr)
            raise typer.Exit(1 if isinstance(error, _NO) else 2) from None


def _in_options(message: str, parameters: Iterable[Any]) -> str:
    """The message with the command's options where the library names its arguments.

    "rate: needed" becomes "--rate: needed", angles='degrees' becomes --angles degrees, and
    columns['joints'] becomes --column joints.
    """
    options: dict[str, str] = {
        name: parameter.opts[0]
        for parameter in parameters
        if parameter.param_type_name == "option"
        for name in (parameter.name, f"{parameter.name}s")
    }
    argument = rf"\b(?P<name>{'|'.join(options) or '(?!)'})"

    def option(found: re.Match[str]) -> str:
        value = f" {found['value']}" if found["value"] else ""
        return options[found["name"]] + value

    message = re.sub(rf"(?:^|(?<=: )){argument}(?P<value>)(?=: |\[\d+\]: )", option, message)
    return re.sub(rf"{argument}(?:\['|=')(?P<value>\w+)'\]?", option, message)
