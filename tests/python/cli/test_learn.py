"""`leadthrough learn`: its errors and warnings name the recordings."""

import numpy as np
from cli.command_line import run, write_table


def written(folder, name, rows, header="t,x,y,z"):
    return write_table(folder / f"{name}.csv", header, rows)


def reach(at=0.5):
    """Times and points of a reach that rests for a second at a fraction of its length."""
    t = np.linspace(0.0, 3.0, 150)
    u = np.interp(t, [0.0, 2.0 * at, 2.0 * at + 1.0, 3.0], [0.0, at, at, 1.0])
    return np.column_stack([t, u, np.sin(6.0 * u), 0.1 * u])


def test_joints_for_a_model_of_points_and_poses_are_named_with_what_learns_them(tmp_path):
    shown = written(tmp_path, "bump", reach(), header="t,a,b,c")
    words = ("learn", shown, "--column", "joints=a,b,c", "--model", "fast-marching")
    said = run(*words, "-o", tmp_path / "s.npz", code=2).stderr
    assert "--model: fast-marching learns points or poses, and bump has joints; use promp" in said


def test_a_recording_that_cannot_be_learned_is_named(tmp_path):
    still = np.column_stack([np.linspace(0.0, 1.0, 20), np.ones((20, 3))])
    files = [written(tmp_path, "moves", reach()), written(tmp_path, "frozen", still)]
    said = run("learn", *files, "--model", "promp", "-o", tmp_path / "s.npz", code=1).stderr
    assert "frozen: does not move" in said


def test_recordings_out_of_step_are_named_and_learned(tmp_path):
    files = [written(tmp_path, f"r{i}", reach(at)) for i, at in enumerate((0.5, 0.5, 0.5, 0.9))]
    said = run("learn", *files, "--model", "promp", "-o", tmp_path / "s.npz").stderr
    assert "warning: r3: misaligned" in said
    assert (tmp_path / "s.npz").exists()
