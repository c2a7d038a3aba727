import numpy as np
import pytest
from cli.command_line import facts, run
from scipy.io import savemat

import leadthrough as lt


@pytest.fixture
def faulty(tmp_path):
    """Two seconds of a joint at 100 Hz, a number missing at 0.5 s and a leap at 1 s."""
    times = np.arange(201) / 100.0
    angles = [f"{np.sin(time):.6f}" for time in times]
    angles[50], angles[100] = "", "9"
    rows = [f"{time},{angle}" for time, angle in zip(times, angles, strict=True)]
    path = tmp_path / "faulty.csv"
    path.write_text("\n".join(["t,elbow_joint", *rows]))
    return path


def test_faults_are_left_out_and_told(faulty, tmp_path):
    out = tmp_path / "clean.csv"
    said = run("clean", faulty, "-o", out).output
    assert "201 samples read, 199 left" in said
    assert "1 spike, left out: 1 s" in said
    assert len(lt.read_motion(out).times) == 199


def test_machines_get_the_report_as_json(faulty, tmp_path):
    out = tmp_path / "clean.npz"
    (found,) = facts("clean", faulty, "--new-rate", 50, "--smoothing", 0.2, "-o", out)
    assert found["report"]["spikes"] == [1.0]
    shown = lt.read_motion(found["file"])
    assert np.abs(shown.velocities[:, 0] - np.cos(shown.times)).max() < 0.02


def test_several_recordings_go_to_numbered_files(tmp_path):
    path = tmp_path / "several.mat"
    shown = np.empty((1, 2), dtype=object)
    for i in range(2):
        shown[0, i] = {"pos": np.arange(30.0).reshape(3, 10) + i}
    savemat(path, {"shown": shown})
    run("clean", path, "--rate", 10, "-o", tmp_path / "clean.csv")
    for i in (1, 2):
        motion = lt.read_motion(tmp_path / f"clean_{i}.csv")
        assert motion.positions[0, 0] == i - 1


def test_a_strict_reader_says_what_to_do(faulty):
    with pytest.raises(lt.errors.InvalidInput, match=r"line 52, .* `leadthrough clean`"):
        lt.read_demonstrations(faulty)


def test_a_recording_that_cannot_be_cleaned_is_named(tmp_path):
    for name, times in (("whole", [0.0, 0.1, 0.2, 0.3]), ("torn", [0.0, 0.1, 0.2, 9.0])):
        rows = [f"{time},{time},0" for time in times]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t,x,y", *rows]))
    for words in (("learn", "--clean", "-o", "skill.npz"), ("clean", "-o", "clean.csv")):
        told = run(words[0], tmp_path, *words[1:-1], tmp_path / words[-1], code=2).stderr
        assert "torn: no sample from 0.2 to 9 s" in told
