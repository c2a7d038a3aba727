"""Common to all commands: options from the profile, and errors in the words of the command line.

The profile `leadthrough.toml` holds options that all commands take in its folder; an option on the
command line wins.

    robot = "arm.urdf"
    tip = "tool0"
    limits = "arm.toml"
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

import leadthrough as lt
from leadthrough.cli import output

# Typer's root of what is wrong with the words of a command line.
_UsageError: Any = typer.BadParameter.__bases__[0]
# Names of these types' values in --help.
_KINDS = {"path": "FILE", "Path": "FILE", "str": "TEXT", "float": "NUMBER", "int": "NUMBER"}
_JSON = "leadthrough.json"
PROFILE = "leadthrough.toml"
PROFILE_KEYS = ("robot", "base", "tip", "limits", "mesh_folder")
# They describe one arm: with another one on the command line, they hold no more.
OF_THE_ROBOT = PROFILE_KEYS[1:]


def words(ctx: Any) -> dict[str, str]:
    """The library's arguments in the user's words: the option, or the profile's key."""
    found: dict[str, str] = {}
    for parameter in ctx.command.params:
        option = parameter.opts[0]
        if option == f"--{parameter.name.replace('_', '-')}":
            said = option
            if output.source(ctx, parameter.name) == "DEFAULT_MAP":
                said = found[option] = f"{PROFILE}: {parameter.name}"
            found[parameter.name] = found[f"{parameter.name}s"] = said
    return found


class Command(TyperCommand):
    """A command that takes options from the profile and reports errors by the options' names."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        _name_values(self.params)

    def get_help_option(self, ctx: Any) -> Any:
        option = super().get_help_option(ctx)
        _name_values([option] if option else [])
        return option

    def make_context(self, info_name: str | None, args: list[str], **extra: Any) -> Any:  # type: ignore[override]
        parent = extra.get("parent")
        wanted = (
            not extra.get("resilient_parsing")
            and "--help" not in args
            and not (parent and parent.params.get("no_profile"))
        )
        if wanted and any(parameter.name == "robot" for parameter in self.params):
            extra["default_map"] = read_profile()
        return super().make_context(info_name, args, **extra)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        _refuse_files_like_options(self, ctx, args)
        rest = super().parse_args(ctx, args)
        if output.source(ctx, "robot") == "COMMANDLINE":
            for name in OF_THE_ROBOT:
                if output.source(ctx, name) == "DEFAULT_MAP":
                    ctx.params[name] = None
        return rest

    def invoke(self, ctx: Any) -> Any:
        try:
            with output.warnings_in(words(ctx)):
                return super().invoke(ctx)
        except BrokenPipeError:  # a reader such as `head` has seen enough
            raise
        except (lt.errors.LeadthroughError, OSError) as error:
            if ctx.find_root().params.get("debug"):
                raise
            raise output.ending(error, words(ctx), as_json=_wants_json(ctx)) from None


def _refuse_files_like_options(command: Command, ctx: Any, args: list[str]) -> None:
    """Refuses a file such as -out.csv of `learn *.csv`, of which -o would take the rest."""
    options = {option for each in command.get_params(ctx) for option in each.opts}
    words = args[: args.index("--")] if "--" in args else args
    for word in words:
        if word.startswith("-") and word not in options and _is_file(word):
            raise _UsageError(
                f"{word}: looks like an option, and a file of this name is here; write ./{word} "
                "for the file",
                ctx,
            )


def _is_file(word: str) -> bool:
    try:
        return Path(word).exists()
    except (OSError, ValueError):  # no name of a file
        return False


class Commands(TyperGroup):
    """The commands; what is wrong with the words of a command line is JSON too where asked for."""

    def get_help_option(self, ctx: Any) -> Any:
        option = super().get_help_option(ctx)
        _name_values([*self.params, *([option] if option else [])])
        return option

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        ctx.meta[_JSON] = "--json" in args
        with _usage_errors(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        with _usage_errors(ctx):
            return super().invoke(ctx)


def _name_values(parameters: list[Any]) -> None:
    """Lets --help say what a value is without Python's types, and nothing for a switch."""
    for parameter in parameters:
        if parameter.param_type_name == "option" and parameter.metavar is None:
            types = set(re.findall(r"\w+", parameter.display_type(None)))
            kinds = [kind for name, kind in _KINDS.items() if name in types]
            parameter.metavar = "" if parameter.is_flag else next(iter(kinds), None)


@contextmanager
def _usage_errors(ctx: Any) -> Iterator[None]:
    try:
        yield
    except typer.Exit:  # by --help, which needs none of the library
        raise
    except _UsageError as error:
        if not _wants_json(ctx):
            raise
        parameter = getattr(error, "param", None)
        argument = parameter.opts[0] if parameter else getattr(error, "option_name", None)
        output.print_json("UsageError", error.format_message(), argument)
        raise typer.Exit(error.exit_code) from None
    except lt.errors.LeadthroughError as error:  # of the profile, or of a command with --debug
        if ctx.params.get("debug"):
            raise
        raise output.ending(error, {}, as_json=_wants_json(ctx)) from None


def _wants_json(ctx: Any) -> bool:
    return bool(ctx.meta.get(_JSON))


def read_profile() -> dict[str, str]:
    """The options in the working directory's profile, by their names."""
    import tomllib

    try:
        text = Path(PROFILE).read_text(encoding="utf-8")
        document = tomllib.loads(text)
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise lt.errors.InvalidInput(f"{PROFILE}: cannot be read ({error})") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise lt.errors.InvalidInput(f"{PROFILE}: not a TOML document: {error}") from None
    return _checked(document)


def _checked(document: Mapping[str, Any]) -> dict[str, str]:
    for key, value in document.items():
        if key not in PROFILE_KEYS:
            raise lt.errors.InvalidInput(
                f"{PROFILE}: {key}: unknown key; the keys are {', '.join(PROFILE_KEYS)}"
            )
        if not isinstance(value, str) or not value:
            raise lt.errors.InvalidInput(
                f"{PROFILE}: {key}: expected a text in quotes, got {value!r}"
            )
        if "robot" not in document:
            raise lt.errors.InvalidInput(
                f"{PROFILE}: {key}: only used with robot; add robot or remove {key}"
            )
    return dict(document)
