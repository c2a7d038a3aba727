"""The inverse kinematics of other libraries, with one common signature."""

from __future__ import annotations

import re
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from tempfile import NamedTemporaryFile, TemporaryDirectory
from typing import Any

import roboticstoolbox as rtb
from eaik.IK_URDF import UrdfRobot
from trac_ik import TracIK

import leadthrough as lt

PEER_TOLERANCE = 1e-5  # m and rad
TRAC_IK_TOLERANCE = 2.0 * PEER_TOLERANCE  # m and rad: its tolerance applies to each axis
TRAC_IK_TIMEOUT = 0.005  # s of wall clock, its default

Solve = Callable[[Any, Any], Any]  # target (pin.SE3) and seed to q or None


def toolbox(arm: lt.Arm, urdf: Path) -> Solve:
    """Levenberg-Marquardt of roboticstoolbox, in C++."""
    with warnings.catch_warnings(), NamedTemporaryFile("w", suffix=".urdf") as file:
        warnings.simplefilter("ignore", DeprecationWarning)
        # It looks for visual meshes where no other package has them.
        file.write(re.sub(r"<visual>.*?</visual>", "", urdf.read_text(), flags=re.DOTALL))
        file.flush()
        chain = rtb.ERobot.URDF(file.name).ets(start=arm.base, end=arm.tip)
    residual = 0.5 * PEER_TOLERANCE**2  # its residual is half the squared error

    def solve(target: Any, seed: Any) -> Any:
        solution = chain.ik_LM(target.homogeneous, q0=seed, tol=residual)
        return solution.q if solution.success else None

    return solve


def eaik(urdf: Path) -> Any:
    """The closed form of EAIK, of an arm whose URDF has no other joints."""
    return UrdfRobot(str(urdf))


def ssik(arm: lt.Arm, urdf: Path) -> dict[str, Any]:
    """The functions of the solver that ssik writes for an arm: its fastest from Python."""
    with TemporaryDirectory() as folder:
        solver = Path(folder) / "solver.py"
        command = [Path(sys.executable).with_name("ssik"), "build", urdf, "--out", solver]
        subprocess.run(
            [*command, "--base", arm.base, "--ee", arm.tip], check=True, capture_output=True
        )
        return run_path(str(solver))


def trac_ik(arm: lt.Arm, urdf: Path) -> Solve:
    """TRAC-IK, on two threads."""
    solver = TracIK(arm.base, arm.tip, urdf, timeout=TRAC_IK_TIMEOUT, epsilon=PEER_TOLERANCE)
    return lambda target, seed: solver.ik(target.translation, target.rotation, seed)
