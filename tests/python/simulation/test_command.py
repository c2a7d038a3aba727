"""`leadthrough simulate` and `leadthrough check --physics`."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import run

import leadthrough as lt


@pytest.fixture(scope="module")
def folder(tmp_path_factory, swing):
    """A folder with a motion of a Panda."""
    made = tmp_path_factory.mktemp("simulated")
    lt.write_motion(swing, made / "swing.npz")
    return made


@pytest.fixture(autouse=True)
def _there(folder, monkeypatch):
    monkeypatch.chdir(folder)


def test_a_sound_motion_is_fit_to_run_and_shown():
    result = run("simulate", "swing.npz", "--robot", "panda", "--friction", "0.2")
    assert "fit to run   yes" in result.stdout
    page = result.stdout.split()[-1]
    run("simulate", "swing.npz", "--robot", "panda", "--html", page)
    assert "planned arm" in Path(page).read_text() or Path(page).stat().st_size > 100_000


def test_a_heavier_payload_is_found():
    words = ["swing.npz", "--robot", "panda", "--mass", "1", "--payload", "3"]
    found = json.loads(run("simulate", *words, "--json", code=1).stdout)
    assert not found["fit_to_run"]
    assert "what the gains allow" in found["findings"][0]
    assert "next: state the right --mass" in run("simulate", *words, code=1).stdout


def test_the_arm_is_a_real_one_unless_an_ideal_one_is_asked_for():
    words = ["simulate", "swing.npz", "--robot", "panda", "--json"]
    real, ideal, given = (
        json.loads(run(*words, *more).stdout)["tip_error"]
        for more in ([], ["--ideal"], ["--ideal", "--friction", "0.5"])
    )
    assert ideal < 1e-9
    assert 1e-4 < real < 5e-3
    assert given > 1e-4


def test_a_motion_that_asks_too_much_torque_is_fit_once_timed_as_said(swing):
    arm = lt.Arm.load("panda")
    still = np.zeros_like(swing.positions)
    effort = 1.02 * np.abs(arm.inverse_dynamics(swing.positions, still, still)).max(axis=0) + 5.0
    rows = zip(arm.joint_names, effort, arm.limits.acceleration, arm.limits.jerk, strict=True)
    limits = "".join(
        f"{name} = {{ effort = {most:.3f}, acceleration = {bend}, jerk = {jerk} }}\n"
        for name, most, bend, jerk in rows
    )
    Path("weak.toml").write_text(f"[joints]\n{limits}")
    weak = ("--robot", "panda", "--limits", "weak.toml")
    run("retime", "swing.npz", *weak, "-o", "quick.npz")
    (hint,) = re.findall(
        r"^next: leadthrough (.*)", run("simulate", "quick.npz", *weak, code=1).stdout, re.MULTILINE
    )
    run(*hint.split())
    assert "fit to run   yes" in run("simulate", hint.split()[-1], *weak).stdout


def test_controllers_and_disturbances_are_taken():
    run(
        *("simulate", "swing.npz", "--robot", "panda", "--controller", "cartesian-impedance"),
        *("--stiffness", "2000", "--push", "0.2,0,5,0", "--delay", "0.001", "--damping", "0.1"),
        *("--encoder", "1e-6", "--start", "0.02,-0.5,0,-2,0,1.6,0.7"),
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--stiffness", "5"], "--stiffness: only used with another --controller"),
        (["--payload", "2"], "--payload: only used with --mass"),
        (["--skill", "none.npz"], "--skill: only used with --controller cartesian-impedance"),
        (["--push", "1,2,3,x"], "--push"),
    ],
)
def test_options_that_do_not_go_together_are_named(words, said):
    assert said in run("simulate", "swing.npz", "--robot", "panda", *words, code=2).stderr


def test_the_check_simulates_where_it_is_asked_to():
    middle = "box:0.05,0.05,0.3@0.46,0.1,0.55"
    sound = json.loads(run("check", "swing.npz", "--robot", "panda", "--physics", "--json").stdout)
    assert sound["ok"] and sound["simulated"]["fit_to_run"]
    words = ["check", "swing.npz", "--robot", "panda", "--physics", "--obstacle", middle]
    hit = json.loads(run(*words, "--json", code=1).stdout)
    assert not hit["clear"] and not hit["simulated"]["fit_to_run"]
    assert "simulated" not in run("check", "swing.npz", "--robot", "panda").stdout


@pytest.mark.parametrize("words", [["simulate"], ["check", "--physics"]])
def test_without_mujoco_one_line_names_the_extra(words, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    said = run(*words, "swing.npz", "--robot", "panda", code=2).stderr.strip()
    assert said.splitlines() == [
        "leadthrough: mujoco is not installed; install it with: "
        "pip install 'leadthrough[simulation]'"
    ]


def test_an_export_begins_where_the_arm_is(folder):
    """Joint 7 has turned by 0.2 rad meanwhile; the way from there is written with the motion."""
    words = ["retime", "swing.npz", "--robot", "panda", "-o", "from_there.npz"]
    run(*words, "--start", "0,-0.5,0,-2,0,1.6,0.9")
    made, arm = lt.read_motion("from_there.npz"), lt.Arm.load("panda")
    start = [0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.9]
    np.testing.assert_allclose(made.positions[0], start, rtol=0.0, atol=1e-12)
    assert lt.check_limits(made, arm.limits).ok
    assert run("simulate", "from_there.npz", "--robot", "panda")
    block = ("--obstacle", "box:0.1,0.1,1@0.5,0.15,0.5")
    blocked = run(*words, "--start", "0.5,-0.5,0,-2,0,1.6,0.9", *block, code=1)
    assert "is not clear" in blocked.stderr
    assert "connect_configurations" not in blocked.stderr
