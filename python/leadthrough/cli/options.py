"""Options that several commands share, and the shell completion of their values.

A parameter is named as the library names the argument, so that errors can name the option.
Completion computes nothing, so that the shell answers at once; whatever goes wrong offers nothing.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

import typer

import leadthrough as lt
from leadthrough.cli import output
from leadthrough.cli.command import read_profile
from leadthrough.io.headers import AngleUnit, QuaternionOrder
from leadthrough.models.registry import MODELS

if TYPE_CHECKING:
    from leadthrough.io.table import Ranges, Request

STUDIES = (
    "agriculture",
    "augmentation",
    "chunks",
    "comparison",
    "connection",
    "elbow",
    "human",
    "lasa",
    "robotasks",
    "simulation",
    "singularity",
    "trajectories",
    "ur3",
)
SHAPES = (
    "box:0.1,0.1,0.4@0.5,0,0.2",
    "sphere:0.1@0.5,0,0.2",
    "capsule:0.05,0.3@0.5,0,0.2",
    "cylinder:0.05,0.3@0.5,0,0.2",
)
# As `leadthrough.io` reads them.
OBSTACLE_FILES = {
    "mesh": (".stl", ".obj", ".dae"),
    "cloud": (".pcd", ".ply", ".npy", ".csv", ".txt", ".xyz"),
}
_URDF = (".urdf", ".xml", ".xacro")
_LINK = re.compile(r"<link\s[^>]*?name\s*=\s*[\"']([^\"']+)")

Complete = Callable[[str], list[str]]


def one_of(*values: str) -> Complete:
    return lambda incomplete: _beginning(values, incomplete)


def files_ending(*suffixes: str) -> Complete:
    """Completion of files with these suffixes, and of folders, on the way to them."""
    return lambda incomplete: _files(incomplete, suffixes)


def complete_obstacles(incomplete: str) -> list[str]:
    """Examples of obstacles, and files of meshes and points after mesh: and cloud:."""
    kind, colon, start = incomplete.partition(":")
    if colon and kind in OBSTACLE_FILES:
        return [f"{kind}:{file}" for file in _files(start, OBSTACLE_FILES[kind])]
    return _beginning((*SHAPES, *(f"{each}:" for each in OBSTACLE_FILES)), incomplete)


def complete_recordings(incomplete: str) -> list[str]:
    """Files of recordings or motions in any format that can be read, and folders."""
    return _files(incomplete, _readable())


def complete_anything(incomplete: str) -> list[str]:
    """Inputs of `leadthrough info`: files of recordings, skills and URDFs, and folders."""
    return _files(incomplete, (*_readable(), *_URDF))


def complete_formats(incomplete: str) -> list[str]:
    known = lt.io.formats.FORMATS
    return _beginning((each.name for each in known if each.write is not None), incomplete)


def complete_robots(incomplete: str) -> list[str]:
    """The robots that come with the package, and URDFs."""
    from leadthrough.arm.robot_files import own_names

    return [*_beginning(own_names(), incomplete), *_files(incomplete, _URDF)]


def complete_links(ctx: typer.Context, incomplete: str) -> list[str]:
    """The links of the robot that the command line or the profile names."""
    from leadthrough.arm.robot_files import find_robot

    with suppress(lt.errors.LeadthroughError, OSError, UnicodeDecodeError):
        files_named = (str(file) for file in ctx.params.get("files") or ())
        robot = ctx.params.get("robot") or next(files_named, None) or read_profile().get("robot")
        path = Path(robot or "")
        text = (path if path.is_file() else find_robot(str(robot)).urdf).read_text("utf-8")
        return _beginning(_LINK.findall(text), incomplete)
    return []


def complete_models(incomplete: str) -> list[str]:
    return _beginning(lt.models.model_names(), incomplete)


def complete_parameters(ctx: typer.Context, incomplete: str) -> list[str]:
    """The parameters of the model that --model names, with their defaults."""
    with suppress(lt.errors.LeadthroughError):
        known = fields(lt.models.model_entry(ctx.params.get("model") or "").load())
        return _beginning((f"{field.name}={field.default}" for field in known), incomplete)
    return []


def _beginning(values: Iterable[str], incomplete: str) -> list[str]:
    return [value for value in values if value.startswith(incomplete)]


def _readable() -> tuple[str, ...]:
    readable = (each for each in lt.io.formats.FORMATS if each.read is not None)
    return tuple(suffix for each in readable for suffix in each.suffixes)


def _files(incomplete: str, suffixes: tuple[str, ...]) -> list[str]:
    folder, _, start = incomplete.rpartition("/")
    prefix = f"{folder}/" if "/" in incomplete else ""
    found = []
    with suppress(OSError):
        for path in sorted(Path(prefix or ".").expanduser().iterdir()):
            if path.name.startswith(start) and not (path.name.startswith(".") and not start):
                if path.is_dir():
                    found.append(f"{prefix}{path.name}/")
                elif path.suffix.lower() in suffixes:
                    found.append(prefix + path.name)
    # A shell ends a word that is complete with a blank; a folder is only half the way.
    if len(found) == 1 and found[0].endswith("/"):
        return _files(found[0], suffixes) or found
    return found


EXAMPLES = ("reach",)
_ROBOT = typer.Option(
    "--robot",
    help="Robot: panda, tiago, ur3, the path of a URDF, or, where these packages are installed, a "
    "robot of example-robot-data or robot_descriptions.",
    autocompletion=complete_robots,
)
Recordings = Annotated[
    list[Path],
    typer.Argument(
        help="Recordings, in any format that `leadthrough info` reads, or folders of them.",
        autocompletion=complete_recordings,
    ),
]
MotionFile = Annotated[
    Path,
    typer.Argument(
        help="Motion file, in any format that `leadthrough info` reads.",
        autocompletion=complete_recordings,
    ),
]
SkillFile = Annotated[
    Path,
    typer.Argument(
        help="Skill file, as written by `leadthrough learn`.",
        autocompletion=files_ending(".npz"),
    ),
]
_Link = Annotated[str | None, typer.Option(autocompletion=complete_links)]
SkillOutput = Annotated[Path, typer.Option("--out", "-o", autocompletion=files_ending(".npz"))]
DataSetOutput = Annotated[
    Path, typer.Option("--out", "-o", autocompletion=files_ending(".hdf5", ".h5"))
]
StudyName = Annotated[str | None, typer.Argument(autocompletion=one_of(*STUDIES))]
Model = Annotated[str | None, typer.Option(autocompletion=complete_models)]
ModelToFit = Annotated[
    str | None,
    typer.Option(
        help=f"Model to fit: {', '.join(each.name for each in MODELS)}, or one that another "
        "package adds; by default the family that predicts left-out recordings best.",
        autocompletion=complete_models,
    ),
]
Parameters = Annotated[list[str] | None, typer.Option("--set", autocompletion=complete_parameters)]
AnyFiles = Annotated[list[Path], typer.Argument(autocompletion=complete_anything)]
MaybeMotion = Annotated[Path | None, typer.Argument(autocompletion=complete_recordings)]
Demonstrations = Annotated[list[Path] | None, typer.Option(autocompletion=complete_recordings)]
ExampleName = Annotated[str, typer.Argument(autocompletion=one_of(*EXAMPLES))]
Recorded = Annotated[str | None, typer.Option(autocompletion=complete_recordings)]
SkillPath = Annotated[Path | None, typer.Option(autocompletion=files_ending(".npz"))]
PagePath = Annotated[Path | None, typer.Option(autocompletion=files_ending(".html"))]
RobotName = Annotated[str, _ROBOT]
ArmArgument = Annotated[str, typer.Argument(autocompletion=complete_robots)]
MaybeRobotName = Annotated[str | None, _ROBOT]
Obstacles = Annotated[
    list[str] | None,
    typer.Option(
        "--obstacle",
        help="Obstacle in the arm's base frame, in m: box:SX,SY,SZ@X,Y,Z, sphere:R@X,Y,Z, "
        "capsule:R,L@X,Y,Z, cylinder:R,L@X,Y,Z, mesh:FILE@X,Y,Z (hulls of its parts; FILE,0.001 "
        "for one in mm) or cloud:FILE,R@X,Y,Z (balls of radius R around points); append the "
        "quaternion /W,X,Y,Z to rotate it. A file needs no position. May be repeated.",
        autocompletion=complete_obstacles,
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
        autocompletion=complete_recordings,
    ),
]
FormatName = Annotated[
    str | None,
    typer.Option(
        "--format",
        help="Output format, if not set by the suffix of --out: csv, npz, json, yaml, rosbag, "
        "urscript or franka.",
        autocompletion=complete_formats,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
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
        autocompletion=one_of("local:2", "tcp://"),
    ),
]
TaskTimeout = Annotated[
    float | None,
    typer.Option(help="Longest time that one task may take, in s; by default any time."),
]


@dataclass(frozen=True)
class ArmDetails:
    """Options that complete a robot's name.

    Options:
        limits: TOML file with the limits that a URDF cannot hold: acceleration and jerk.
        base: First link of the arm; by default the root link of the URDF.
        tip: Last link of the arm; needed if the URDF has several end links.
        mesh_folder: Folder with the meshes that the URDF names, if they do not lie beside it.
    """

    limits: Annotated[Path | None, typer.Option(autocompletion=files_ending(".toml"))] = None
    base: _Link = None
    tip: _Link = None
    mesh_folder: Annotated[Path | None, typer.Option(autocompletion=files_ending())] = None


@dataclass(frozen=True)
class ReadOptions:
    """Options that say how recordings are read.

    Options:
        column: Columns to read: time=t, positions=x,y,z, orientations=qw,qx,qy,qz or
            joints=q1,q2; may be repeated. Patterns such as joints=q* stand for all that fit. By
            default found by their names; those of an .npy are numbered from 1 on.
        rate: Sampling rate of recordings without a time column, in Hz.
        angles: Unit of joint angles if the file does not state it: radians (the default),
            degrees, or percent of the joints' ranges, as LeRobot has them.
        quaternions: Order of quaternion components if the column names do not state it: wxyz
            or xyzw.
        topic: Topic of a ROS bag; needed if several hold motions.
    """

    column: list[str] | None = None
    rate: float | None = None
    angles: AngleUnit | None = None
    quaternions: QuaternionOrder | None = None
    topic: str | None = None

    def arguments(self) -> dict[str, Any]:  # Any: the reading functions' types differ
        """The arguments of `leadthrough.io.read_demonstrations` that they make."""
        from leadthrough.cli import parse

        columns = parse.columns(self.column or [])
        return {name: value for name, value in vars(self).items() if name != "column"} | {
            "columns": columns
        }

    def request(self, joints: Ranges | None = None) -> Request:
        """The request that they make, for an arm's joints with their limits."""
        from leadthrough.io.table import as_request

        return as_request(**self.arguments(), joints=joints)


def reading_words(ctx: typer.Context) -> tuple[str, ...]:
    """The options that say how recordings are read, as they were typed."""
    return output.typed(ctx, *(each.name for each in fields(ReadOptions)))


@dataclass(frozen=True)
class RestOptions:
    """Options of `leadthrough.preprocess.trim`.

    Options:
        rest: Standing still to keep before and after a motion, in s; by default none, inf keeps
            all of it.
        speed: Speed at which a motion begins, in m/s (rad/s for joints); below half of it the
            arm stands still. By default it follows from the recording's noise.
        angular_speed: The same for the orientation of poses, in rad/s.
    """

    rest: float = 0.0
    speed: float | None = None
    angular_speed: float | None = None


def flattened(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of its option groups as parameters of its own.

    The docstring's section "Options" has the help of each parameter whose type has none.
    """
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: kind for name, kind in hints.items() if is_dataclass(kind)}
    text, helps = _documented(command)
    for kind in groups.values():
        helps |= _documented(kind)[1]
    parameters = []
    for name, parameter in inspect.signature(command).parameters.items():
        own = [parameter.replace(annotation=hints[name])]
        if name in groups:
            own = list(inspect.signature(groups[name], eval_str=True).parameters.values())
        parameters += [
            each.replace(
                kind=inspect.Parameter.KEYWORD_ONLY,
                annotation=_with_help(each.name, each.annotation, helps.pop(each.name, None)),
            )
            for each in own
        ]
    assert not helps, f"{command.__name__} has no {', '.join(helps)}"

    def flat(**values: Any) -> None:
        for name, kind in groups.items():
            values[name] = kind(**{each.name: values.pop(each.name) for each in fields(kind)})
        command(**values)

    flat.__name__, flat.__doc__ = command.__name__, text
    flat.__annotations__ = {each.name: each.annotation for each in parameters}
    flat.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return flat


def _documented(command: object) -> tuple[str, dict[str, str]]:
    """The docstring of a command or group without its section "Options", and that by name."""
    text, _, section = (inspect.getdoc(command) or "").partition("\n\nOptions:\n")
    helps = re.findall(r"^ {4}(\w+): (.*(?:\n {8}.*)*)", section, re.MULTILINE)
    return text, {name: " ".join(help.split()) for name, help in helps}


def _with_help(name: str, kind: Any, help: str | None) -> Any:  # Any: types, plain and annotated
    if help is None:
        return kind
    plain, *known = get_args(kind) if get_origin(kind) is Annotated else (kind,)
    switch = [f"--{name.replace('_', '-')}"] if plain is bool else []  # and no --no-...
    option = copy(known[0]) if known else typer.Option(*switch)
    option.help = help
    return Annotated[plain, option]


def of_model(model: object) -> dict[str, str]:
    """The command line's words for a model's parameters."""
    return {name: f"--set {name}" for name in getattr(type(model), "__dataclass_fields__", ())}
