"""`import leadthrough` is light: each part is loaded when it is first used."""

import ctypes
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import leadthrough as lt

HEAVY = {"matplotlib", "numpy", "rich", "scipy", "yaml"}


def modules_after(code):
    """The modules that a fresh interpreter has loaded after some code."""
    report = f"{code}\nimport sys; print(*sys.modules, sep='\\n')"
    result = subprocess.run(
        [sys.executable, "-c", report], capture_output=True, text=True, timeout=60, check=True
    )
    return set(result.stdout.splitlines())


def test_importing_the_package_loads_none_of_its_parts_and_no_heavy_library():
    loaded = modules_after("import leadthrough")
    assert not loaded & HEAVY
    assert not {name for name in loaded if name.startswith("leadthrough.")}


def test_the_command_line_loads_no_library_that_computes_or_draws():
    loaded = modules_after("import leadthrough.cli")
    assert not loaded & (HEAVY - {"rich"})  # typer's own --help is printed by rich


def test_commands_that_clean_learn_plan_time_check_guard_and_show_load_no_library_they_do_not_use(
    tmp_path,
):
    times = np.linspace(0.0, 2.0, 30)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 2.0)[:, None]
    names = ("shown.csv", "posed.csv", "joints.csv")
    shown, posed, joints = (str(tmp_path / name) for name in names)
    turned = lt.rotations.exp(s * [0.1, 0.2, 0.3])
    lt.write_motion(lt.PoseTrajectory(times, s * [0.3, 0.2, 0.1], turned), posed)
    lt.write_motion(lt.Trajectory(times, s * [0.3, 0.2, 0.1]), shown)
    bent = s * 0.3 + [0.0, -1.0, 1.0, -1.0, -1.0, 0.0]
    lt.write_motion(
        lt.JointTrajectory(times, bent, joint_names=lt.Arm.load("ur3").joint_names), joints
    )
    lines = [
        ["clean", shown, "-o", "cleaned.csv"],
        ["info", shown],
        ["learn", "--model=dmp", posed, "-o", "poses.npz"],
        ["learn", "--model=dmp", shown, "-o", "skill.npz"],
        ["plan", "skill.npz", "-o", "plan.csv"],
        ["check", joints, "--robot", "ur3"],
        ["guard", joints, "--robot", "ur3", "-o", "guarded.csv"],
        ["retime", joints, "--robot", "ur3", "-o", "timed.csv"],
        ["view", joints, "--robot", "ur3", "--html", "view.html"],
    ]
    code = f"""
import os
from typer.testing import CliRunner
from leadthrough import cli
os.chdir({str(tmp_path)!r})
for words in {lines}:
    result = CliRunner().invoke(cli.app, words)
    assert result.exit_code == 0, result.output"""
    assert not modules_after(code) & {"matplotlib", "scipy", "yaml"}


def test_a_model_loads_no_family_but_its_own():
    loaded = modules_after("import leadthrough as lt; lt.DMP")
    names = ("dmp", "dynamical", "gaussians", "marching", "mixtures", "promp")
    families = {f"leadthrough.models.{name}" for name in names}
    assert loaded & families == {"leadthrough.models.dmp"}


@pytest.mark.parametrize(
    "module", ["io.formats", "preprocess", "motion", "shapes", "planning", "trajectories", "timing"]
)
def test_what_reads_holds_plans_or_times_motions_loads_neither_scipy_nor_yaml(module):
    assert not modules_after(f"import leadthrough.{module}") & (HEAVY - {"numpy"})


def test_the_view_is_there_right_after_the_import():
    assert "leadthrough.show.viewing" in modules_after("import leadthrough as lt; lt.show.view")


@pytest.mark.parametrize("package", [lt, lt.io, lt.models, lt.show], ids=lambda each: each.__name__)
def test_every_public_name_is_listed_and_loads(package):
    assert set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        assert getattr(package, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        package.no_such_name  # noqa: B018 (looked up for its error)


def test_objects_of_lazily_loaded_classes_are_pickled():
    motion = lt.Trajectory([0.0, 1.0], [[0.0, 1.0], [2.0, 3.0]])
    assert pickle.loads(pickle.dumps(motion)).positions.tolist() == motion.positions.tolist()


_OWN_BLOCKS = """
import ctypes
class Usage(ctypes.Structure):  # struct mallinfo2 of malloc.h
    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "_1", "_2", "mapped", *"345678")]
libc = ctypes.CDLL(None)
libc.mallinfo2.restype, libc.malloc.argtypes = Usage, [ctypes.c_size_t]
import leadthrough._core
before = libc.mallinfo2().mapped
libc.malloc(3 << 20)
print(libc.mallinfo2().mapped - before)
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="glibc only")
@pytest.mark.parametrize("malloc, mapped", [("", "0"), ("system", "1")])
def test_how_memory_is_kept_can_be_left_to_the_host(malloc, mapped):
    settings = {**os.environ, "LEADTHROUGH_MALLOC": malloc}
    command = [sys.executable, "-c", _OWN_BLOCKS]
    result = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=True, env=settings
    )
    assert result.stdout.strip() == mapped
