"""Something to look at: live in a browser, or as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from leadthrough import check
from leadthrough.errors import InvalidInput

_SHAPES = "box:SIZES@POSITION, sphere:RADIUS@POSITION or capsule:RADIUS,LENGTH@POSITION"


def view(
    motion: Annotated[
        Path | None, typer.Argument(help="The motion to show: joints, or poses to follow.")
    ] = None,
    robot: Annotated[str, typer.Option(help="panda, ur3, tiago, or a URDF file.")] = "panda",
    limits: Annotated[Path | None, typer.Option(help="Limits file, for a URDF.")] = None,
    demonstrations: Annotated[
        list[Path] | None, typer.Option(help="A recording; may be repeated.")
    ] = None,
    skill: Annotated[Path | None, typer.Option(help="A skill, whose goal may be dragged.")] = None,
    obstacle: Annotated[
        list[str] | None, typer.Option(help=f"{_SHAPES}, in m; may be repeated.")
    ] = None,
    html: Annotated[Path | None, typer.Option(help="Write a page to this file instead.")] = None,
    port: Annotated[int, typer.Option(help="Of the live page; 0 takes a free one.")] = 0,
) -> None:
    """Show an arm on its way, live in a browser or as a file that opens without a server.

    leadthrough view motion.csv --robot ur3 --html motion.html

    leadthrough view --robot panda --skill skill.npz --obstacle box:0.1,0.1,0.4@0.5,0,0.2
    """
    from leadthrough.arm import Arm
    from leadthrough.io import read_demonstrations
    from leadthrough.models import load_skill
    from leadthrough.show import viewing

    path = Path(robot)
    arm = Arm.from_urdf(path, limits=limits) if path.suffix else Arm.load(robot)
    viewing.view(
        arm,
        None if motion is None else _motion(motion),
        demonstrations=read_demonstrations(demonstrations) if demonstrations else (),
        skill=None if skill is None else load_skill(skill),
        obstacles=[parse_shape(text) for text in obstacle or ()],
        html=html,
        port=port,
    )
    if html is not None:
        print(f"wrote {html}")


def parse_shape(text: str) -> Any:
    """The shape that a word such as "box:0.1,0.1,0.4@0.5,0,0.2" stands for. Raises InvalidInput."""
    from leadthrough.shapes import Box, Capsule, Sphere

    kind, _, rest = text.partition(":")
    sizes, at, position = rest.partition("@")
    counts = {"box": 3, "sphere": 1, "capsule": 2}
    try:
        numbers = [float(word) for word in sizes.split(",")]
        place = [float(word) for word in position.split(",")]
    except ValueError:
        at = ""
        numbers, place = [], []
    if not at or counts.get(kind) != len(numbers) or len(place) != 3:
        raise InvalidInput(f"obstacle: expected {_SHAPES}, got {text!r}")
    match kind:
        case "box":
            return Box(check.array(numbers, "obstacle", shape=(3,)), place)
        case "sphere":
            return Sphere(numbers[0], place)
    return Capsule(numbers[0], numbers[1], place)


def _motion(path: Path) -> Any:
    from leadthrough.io import read_demonstrations

    found = read_demonstrations(path)
    if len(found) != 1:
        raise InvalidInput(f"{path}: expected one motion, got {len(found)}")
    return found[0].motion
