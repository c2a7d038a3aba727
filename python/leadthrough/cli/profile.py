"""`leadthrough.toml`: options that all commands take in the folder with this file.

    robot = "arm.urdf"
    tip = "tool0"
    limits = "arm.toml"

An option on the command line wins over the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from leadthrough.errors import InvalidInput

FILE = "leadthrough.toml"
KEYS = ("robot", "base", "tip", "limits", "mesh_folder")
# They describe one arm: with another one on the command line, they hold no more.
OF_THE_ROBOT = KEYS[1:]


def read() -> dict[str, str]:
    """The options in the working directory's profile, by their names."""
    import tomllib

    try:
        text = Path(FILE).read_text(encoding="utf-8")
        document = tomllib.loads(text)
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{FILE}: cannot be read ({error})") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InvalidInput(f"{FILE}: not a TOML document: {error}") from None
    return _checked(document)


def _checked(document: Mapping[str, Any]) -> dict[str, str]:
    for key, value in document.items():
        if key not in KEYS:
            raise InvalidInput(f"{FILE}: {key}: unknown key; the keys are {', '.join(KEYS)}")
        if not isinstance(value, str) or not value:
            raise InvalidInput(f"{FILE}: {key}: expected a text in quotes, got {value!r}")
        if "robot" not in document:
            raise InvalidInput(f"{FILE}: {key}: only used with robot; add robot or remove {key}")
    return dict(document)
