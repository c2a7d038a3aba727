"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

MotionFile = Annotated[Path, typer.Argument(help="A motion, in any format that can be read.")]
RobotName = Annotated[str, typer.Option(help="panda, tiago, ur3, or the path of a URDF.")]
MaybeRobotName = Annotated[
    str | None, typer.Option("--robot", help="panda, tiago, ur3, or the path of a URDF.")
]
LimitsFile = Annotated[
    Path | None, typer.Option(help="TOML with what the URDF lacks: acceleration and jerk limits.")
]
BaseLink = Annotated[str | None, typer.Option(help="The arm's first link; by default the root.")]
TipLink = Annotated[str | None, typer.Option(help="The arm's last link; by default the only end.")]
Obstacles = Annotated[
    list[str] | None,
    typer.Option(
        "--obstacle",
        help="box:SX,SY,SZ@X,Y,Z, sphere:R@X,Y,Z or capsule:R,L@X,Y,Z, in m in the arm's base "
        "frame; /W,X,Y,Z behind turns it. May be repeated.",
    ),
]
Output = Annotated[
    Path, typer.Option("--out", "-o", help="Where to; the suffix says the format, as in `info`.")
]
FormatName = Annotated[
    str | None, typer.Option("--format", help="The format, where the suffix does not say it.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        help="Which columns to read: time=t, positions=x,y,z, orientations=qw,qx,qy,qz or "
        "joints=q1,q2; may be repeated. By default found by their names."
    ),
]
Rate = Annotated[float | None, typer.Option(help="Hz, for recordings without a time.")]
Angles = Annotated[str | None, typer.Option(help="Unit of joints: radians or degrees.")]
Quaternions = Annotated[
    str | None, typer.Option(help="Order of quaternions that have no names: wxyz or xyzw.")
]
Topic = Annotated[str | None, typer.Option(help="Of a ROS bag, where several fit.")]
