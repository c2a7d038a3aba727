"""Options that several commands share.

A parameter is named as the library names the argument, so that errors can name the option.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

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
        help="Unit of joint angles if the file does not tell it: radians (the default), degrees, "
        "or percent of the joints' ranges, as LeRobot has them."
    ),
]
Quaternions = Annotated[
    QuaternionOrder | None,
    typer.Option(
        help="Order of quaternion components if the column names do not tell it: wxyz or xyzw."
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


def of_model(model: object) -> dict[str, str]:
    """What the command line calls the parameters of a model, by their names."""
    return {name: f"--set {name}" for name in getattr(type(model), "__dataclass_fields__", ())}
