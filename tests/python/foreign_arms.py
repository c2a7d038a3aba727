"""Arms that are not among ours, and recordings of their joints, as users bring them."""

import importlib.metadata
from pathlib import Path

import numpy as np
import xacro
from motions import minimum_jerk

import leadthrough as lt

# URDF, tip, a posture to start in: the elbow far from the middle of its range.
ARMS = {
    "xarm7": ("xarm7.urdf", "link7", [0.9, -0.6, -1.1, 1.3, 0.7, 1.4, -2.2]),
    "iiwa14": ("lbr_iiwa_14_r820.urdf", "tool0", [1.9, 0.7, -1.6, -1.5, 1.2, 0.9, -1.7]),
    "jaco": (None, "j2s6s200_end_effector", [4.7, 2.9, 1.2, -2.1, 1.4, 8.0]),
}


def urdf_in_package(package, file):
    """The path of a URDF among a package's files."""
    for entry in importlib.metadata.distribution(package).files:
        if entry.name == file:
            return Path(entry.locate())
    raise FileNotFoundError(file)


def urdf_of(name, folder):
    """The path of an arm's URDF; what is only a xacro is expanded into the folder."""
    file, _, _ = ARMS[name]
    if file is None:
        return _expanded(folder)
    try:
        return urdf_in_package("example-robot-data", file)
    except FileNotFoundError:
        return urdf_in_package("rtb-data", file)


def record(path, arm, first, *, seed, noise=5e-4):
    """A reach of an arm at 100 Hz as a CSV of noisy joints, which turn beyond pi as encoders do.

    Returns:
        The joints (n, joints) as they were before the noise.
    """
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, 3.0, 0.01)
    u = times / times[-1]
    rise = minimum_jerk(u)
    way = np.array([0.5, 0.35, -0.3, 0.3, 0.4, -0.3, 0.6])[: len(first)]
    own = np.asarray(first) + rng.normal(0.0, 0.01, len(first))
    q = own + rise[:, None] * (way + rng.normal(0.0, 0.02, len(first)))
    rows = q + rng.normal(0.0, noise, q.shape)
    header = ",".join(["time", *arm.joint_names])
    np.savetxt(path, np.column_stack([times, rows]), delimiter=",", header=header, comments="")
    return q


def _expanded(folder):
    xacro_file = urdf_in_package("rtb-data", "j2s6s200_standalone.xacro")
    package = folder / "kinova_description"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").symlink_to(xacro_file.parents[1] / "meshes")
    for file in (each for each in xacro_file.parent.iterdir() if each.is_file()):
        text = file.read_text().replace("$(find kinova_description)", str(package))
        (package / "urdf" / file.name).write_text(text)
    document = xacro.process_file(str(package / "urdf" / xacro_file.name))
    urdf = package / "urdf" / "j2s6s200.urdf"
    urdf.write_text(document.toxml())
    return urdf


def load(name, folder):
    """The arm, with its tip."""
    return lt.Arm.from_urdf(urdf_of(name, folder), tip=ARMS[name][1])
