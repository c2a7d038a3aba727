"""Errors as a command line tells them: one line, and a code that scripts can ask for."""

from __future__ import annotations

import sys
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

# The question was understood, and there is no such motion.
_NO = (FitError, IkFailure, LimitsInfeasible, NoContinuousLogarithm, NoPath)


class Commands(TyperGroup):
    """Commands whose expected errors are one line on stderr, and a traceback only with --debug."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # a reader such as `head` has seen enough
            raise
        except (LeadthroughError, OSError) as error:
            if ctx.params.get("debug"):
                raise
            print(f"leadthrough: {error}", file=sys.stderr)
            raise typer.Exit(1 if isinstance(error, _NO) else 2) from None
