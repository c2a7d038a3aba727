"""Numbers, shapes and poses from the text of command-line options."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.certificate import TargetRegion
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Target
from leadthrough.shapes import RandomObstacle, Shape
from leadthrough.shapes.primitives import PRIMITIVES

# The forms of --obstacle.
FORMS = (
    *(f"{kind}:{shape.size_names}@X,Y,Z" for kind, shape in PRIMITIVES.items()),
    "mesh:FILE[,SCALE][@X,Y,Z]",
    "cloud:FILE,R[@X,Y,Z]",
)
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# A file's name may have commas and an @ of its own.
_FILE = re.compile(rf"(?s)(.*?)(?:,({_NUMBER}))?(?:@([-+\d.eE,/]+))?")


def numbers(text: str, name: str) -> Float64Array:
    try:
        return np.array([float(part) for part in text.split(",")])
    except ValueError:
        raise InvalidInput(f"{name}: expected numbers such as 0.4,0,0.3, got {text!r}") from None


def tolerances(text: str, name: str) -> tuple[float, float]:
    """Errors M,RAD of a position and an orientation, each > 0."""
    given = check.array(numbers(text, name), name, shape=(2,)).tolist()
    position, orientation = (check.number(each, name, above=0.0) for each in given)
    return position, orientation


def obstacle(text: str) -> Shape:
    """A shape such as box:0.1,0.1,0.2@0.4,0,0.1."""
    with check.prefixed(f"--obstacle {text}"):
        return _shape(text)


def obstacles(given: Sequence[str] | None) -> list[Shape]:
    return [obstacle(text) for text in given or ()]


def _shape(text: str) -> Shape:
    kind, _, rest = text.partition(":")
    if kind in ("mesh", "cloud"):
        return _from_file(kind, rest)
    size_text, _, where = rest.partition("@")
    if kind not in PRIMITIVES or not size_text or not where:
        raise InvalidInput(f"expected {', '.join(FORMS[:-1])} or {FORMS[-1]}")
    shape, sizes = PRIMITIVES[kind], numbers(size_text, "size")
    expected = shape.size_names.count(",") + 1
    if len(sizes) != expected:
        raise InvalidInput(f"expected {expected} sizes for a {kind}, got {len(sizes)}")
    position, orientation = _place(where, "place")
    pose = (position,) if orientation is None else (position, orientation)
    return shape.from_sizes(sizes, *pose)


def _from_file(kind: str, text: str) -> Shape:
    """A mesh or a cloud: the file, a number, and a position, which may be left out."""
    from leadthrough.io import read_mesh, read_point_cloud

    parts = _FILE.fullmatch(text)
    assert parts is not None  # every text has this form
    file, number, where = parts.groups()
    position, rotation = _place(where, "place") if where else (np.zeros(3), None)
    orientation = (1.0, 0.0, 0.0, 0.0) if rotation is None else rotation
    if kind == "mesh":
        scale = float(number or 1.0)
        return read_mesh(file, scale=scale, position=position, orientation=orientation)
    if number is None:
        raise InvalidInput(
            f"expected a radius in m after the file, as in cloud:{file or 'FILE'},0.01"
        )
    return read_point_cloud(file, float(number), position=position, orientation=orientation)


def place(text: str, name: str) -> Target:
    """A point or joint positions, X,Y,Z, or a pose, X,Y,Z/W,X,Y,Z."""
    position, orientation = _place(text, name)
    return position if orientation is None else (position, orientation)


def end(text: str, motion: Motion, index: int, name: str) -> Target:
    """A start or a goal, as by `place`."""
    asked = place(text, name)
    if isinstance(asked, tuple) and not isinstance(motion, PoseTrajectory):
        raise InvalidInput(
            f"{name}: expected no orientation for a skill of {type(motion).__name__}, got {text!r}"
        )
    if isinstance(asked, tuple) or not isinstance(motion, PoseTrajectory):
        return asked
    return asked, motion.orientations[index]


def moved(text: str, motion: Motion, index: int, name: str) -> Target:
    """The first or last position of a motion, moved by an offset; arguments as for `end`."""
    offset = numbers(text, name)
    position = motion.positions[index]
    if len(offset) != len(position):
        raise InvalidInput(f"{name}: expected {_coordinates(motion)}, got {text!r}")
    there = position + offset
    return (there, motion.orientations[index]) if isinstance(motion, PoseTrajectory) else there


def _coordinates(motion: Motion) -> str:
    """How many numbers a position of a motion has, with the reason for joints."""
    count = motion.positions.shape[1]
    if not isinstance(motion, JointTrajectory):
        return f"{count} numbers"
    return (
        f"{count} numbers, one for each joint, as the skill was learned of joints (with --robot, "
        "`leadthrough learn` learns poses of the tool)"
    )


def columns(given: Sequence[str]) -> dict[str, list[str]] | None:
    """The `columns` of `read_demonstrations`, from words such as joints=q1,q2."""
    return {role: names.split(",") for role, names in _pairs(given, "--column")} or None


def places(text: str, middle: Float64Array, name: str) -> TargetRegion:
    """A region: distances to both sides of a position, or two corners, with /ANGLE for poses."""
    sides, _, angle = text.partition("/")
    corners = [numbers(part, name) for part in sides.split(":")]
    for corner in corners:
        if len(corner) != len(middle) or len(corners) > 2:
            raise InvalidInput(f"{name}: expected {len(middle)} numbers, or twice as many with a "
                               f"colon between them, got {text!r}")  # fmt: skip
    turn = float(numbers(angle, name)[0]) if angle else 0.0
    with check.prefixed(name):
        if len(corners) == 1:
            return TargetRegion.around(middle, corners[0], turn=turn)
        return TargetRegion(corners[0], corners[1], turn)


def corners(text: str, name: str) -> TargetRegion:
    """The region between two corners X,Y,Z:X,Y,Z."""
    if text.count(":") != 1:
        raise InvalidInput(f"{name}: expected two corners such as 0,0,0:1,1,1, got {text!r}")
    return places(text, np.zeros(3), name)


def random_obstacle(text: str) -> RandomObstacle:
    """An obstacle at a random position, such as box:0.1,0.1,0.2@0.4,0,0.1~0.1,0.1,0."""
    form, _, reach = text.rpartition("~")
    with check.prefixed(f"--random-obstacle {text}"):
        return RandomObstacle(_shape(form), numbers(reach, "distances"))


def parameters(given: Sequence[str]) -> dict[str, Any]:
    """A model's parameters, from words such as weights=80, each of the type that YAML gives it."""
    if not given:
        return {}
    import yaml

    try:
        return {key: yaml.safe_load(value) for key, value in _pairs(given, "--set")}
    except yaml.YAMLError as error:
        raise InvalidInput(f"--set: {' '.join(str(error).split())}") from None


def _place(text: str, name: str) -> tuple[Float64Array, Float64Array | None]:
    position, _, orientation = text.partition("/")
    return numbers(position, name), numbers(orientation, name) if orientation else None


def _pairs(given: Sequence[str], name: str) -> list[tuple[str, str]]:
    for word in given:
        if "=" not in word:
            raise InvalidInput(f"{name}: expected NAME=VALUE, got {word!r}")
    return [(key, value) for key, _, value in (word.partition("=") for word in given)]
