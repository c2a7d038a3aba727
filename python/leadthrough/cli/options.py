"""Options that several commands share.

A parameter is named as the library names the argument, so that errors can name the option.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from leadthrough.cli import completion
from leadthrough.io.headers import AngleUnit, QuaternionOrder

_ROBOT = typer.Option(
    "--robot",
    help="Robot: panda, tiago, ur3, the path of a URDF, or, where these packages are installed, a "
    "robot of example-robot-data or robot_descriptions.",
    autocompletion=completion.robots,
)
Recordings = Annotated[
    list[Path],
    typer.Argument(
        help="Recordings, in any format that `leadthrough info` reads, or folders of them.",
        autocompletion=completion.recordings,
    ),
]
MotionFile = Annotated[
    Path,
    typer.Argument(
        help="Motion file, in any format that `leadthrough info` reads.",
        autocompletion=completion.recordings,
    ),
]
SkillFile = Annotated[
    Path,
    typer.Argument(
        help="Skill file, as written by `leadthrough learn`.",
        autocompletion=completion.files(".npz"),
    ),
]
RobotName = Annotated[str, _ROBOT]
MaybeRobotName = Annotated[str | None, _ROBOT]
LimitsFile = Annotated[
    Path | None,
    typer.Option(
        help="TOML file with the limits that a URDF cannot hold: acceleration and jerk.",
        autocompletion=completion.files(".toml"),
    ),
]
BaseLink = Annotated[
    str | None,
    typer.Option(
        help="First link of the arm; by default the root link of the URDF.",
        autocompletion=completion.links,
    ),
]
TipLink = Annotated[
    str | None,
    typer.Option(
        help="Last link of the arm; needed if the URDF has several end links.",
        autocompletion=completion.links,
    ),
]
MeshFolder = Annotated[
    Path | None,
    typer.Option(
        help="Folder with the meshes that the URDF names, if they do not lie beside it.",
        autocompletion=completion.files(),
    ),
]
Obstacles = Annotated[
    list[str] | None,
    typer.Option(
        "--obstacle",
        help="Obstacle in the arm's base frame, in m: box:SX,SY,SZ@X,Y,Z, sphere:R@X,Y,Z, "
        "capsule:R,L@X,Y,Z, cylinder:R,L@X,Y,Z, mesh:FILE@X,Y,Z (hulls of its parts; FILE,0.001 "
        "for one in mm) or cloud:FILE,R@X,Y,Z (balls of radius R around points); append the "
        "quaternion /W,X,Y,Z to turn it. Of files the place may be left out. May be repeated.",
        autocompletion=completion.obstacles,
    ),
]
Margin = Annotated[float, typer.Option(help="Clearance to keep from obstacles, in m.")]
Seed = Annotated[int, typer.Option(help="Seed of the random number generator.")]
Output = Annotated[
    Path,
    typer.Option(
        "--out",
        "-o",
        help="Output file; its suffix sets the format: .csv, .npz, .json, .yaml, .mcap, .db3 or "
        ".script.",
        autocompletion=completion.recordings,
    ),
]
FormatName = Annotated[
    str | None,
    typer.Option(
        "--format",
        help="Output format, if not set by the suffix of --out: csv, npz, json, yaml, rosbag, "
        "urscript or franka.",
        autocompletion=completion.formats,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        help="Columns to read: time=t, positions=x,y,z, orientations=qw,qx,qy,qz or joints=q1,q2; "
        "may be repeated. By default found by their names."
    ),
]
Rate = Annotated[
    float | None,
    typer.Option(help="Sampling rate of recordings without a time column, in Hz."),
]
Angles = Annotated[
    AngleUnit | None,
    typer.Option(
        help="Unit of joint angles if the file does not state it: radians (the default), degrees, "
        "or percent of the joints' ranges, as LeRobot has them."
    ),
]
Quaternions = Annotated[
    QuaternionOrder | None,
    typer.Option(
        help="Order of quaternion components if the column names do not state it: wxyz or xyzw."
    ),
]
Topic = Annotated[
    str | None, typer.Option(help="Topic of a ROS bag; needed if several hold motions.")
]
Rest = Annotated[
    float,
    typer.Option(
        help="Standing still to keep before and after a motion, in s; by default none, inf keeps "
        "all of it."
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(
        help="Speed at which a motion begins, in m/s (rad/s for joints); below half of it the arm "
        "stands still. By default it follows from the recording's noise."
    ),
]
AngularSpeed = Annotated[
    float | None,
    typer.Option(help="The same for the turning of poses, in rad/s."),
]
Pause = Annotated[
    float | None,
    typer.Option(help="Shortest standing still that counts as a pause, in s."),
]
FaultTable = Annotated[
    Path | None,
    typer.Option(
        "--table",
        help="CSV file to write with the faults of each recording. Faulty recordings that "
        "cannot be read or cleaned are then skipped, and data sets are read piece by piece.",
    ),
]
On = Annotated[
    str | None,
    typer.Option(
        help="Where to compute: local:N for N processes of this machine, the address of a Dask "
        "scheduler such as tcp://host:8786, or the .json file that it wrote.",
        autocompletion=completion.one_of("local:2", "tcp://"),
    ),
]
TaskTimeout = Annotated[
    float | None,
    typer.Option(help="Longest time that one task may take, in s; by default any time."),
]


@dataclass(frozen=True)
class ArmDetails:
    """Options that complete a robot's name."""

    limits: LimitsFile = None
    base: BaseLink = None
    tip: TipLink = None
    mesh_folder: MeshFolder = None


@dataclass(frozen=True)
class ReadOptions:
    """Options that say how recordings are read."""

    column: Columns = None
    rate: Rate = None
    angles: Angles = None
    quaternions: Quaternions = None
    topic: Topic = None

    def arguments(self) -> dict[str, Any]:  # Any: the reading functions' types differ
        """The arguments of `leadthrough.io.read_demonstrations` that they make."""
        from leadthrough.cli import parse

        columns = parse.columns(self.column or [])
        return {name: value for name, value in vars(self).items() if name != "column"} | {
            "columns": columns
        }


@dataclass(frozen=True)
class RestOptions:
    """Options of `leadthrough.preprocess.trim`."""

    rest: Rest = 0.0
    speed: Speed = None
    angular_speed: AngularSpeed = None


def flattened(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of its option groups as parameters of its own."""
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: kind for name, kind in hints.items() if is_dataclass(kind)}
    parameters = []
    for name, parameter in inspect.signature(command).parameters.items():
        kind = groups.get(name)
        own = inspect.signature(kind, eval_str=True).parameters.values() if kind else [parameter]
        parameters += [
            each.replace(
                kind=inspect.Parameter.KEYWORD_ONLY,
                annotation=each.annotation if kind else hints[name],
            )
            for each in own
        ]

    def flat(**values: Any) -> None:
        for name, kind in groups.items():
            values[name] = kind(**{each.name: values.pop(each.name) for each in fields(kind)})
        command(**values)

    flat.__name__, flat.__doc__ = command.__name__, command.__doc__
    flat.__annotations__ = {each.name: each.annotation for each in parameters}
    flat.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return flat


def of_model(model: object) -> dict[str, str]:
    """The command line's words for a model's parameters."""
    return {name: f"--set {name}" for name in getattr(type(model), "__dataclass_fields__", ())}
