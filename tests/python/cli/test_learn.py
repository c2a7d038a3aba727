"""`leadthrough learn`: errors and warnings name the recordings, whose rests are left out."""

import re
import shlex

import numpy as np
import pytest
from cli.command_line import facts, run, write_table

import leadthrough as lt


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


def test_recordings_out_of_step_are_aligned_and_those_of_rhythms_named(tmp_path):
    files = [written(tmp_path, f"r{i}", reach(at)) for i, at in enumerate((0.5, 0.5, 0.5, 0.9))]
    assert (
        "misaligned"
        not in run("learn", *files, "--model", "promp", "-o", tmp_path / "s.npz").stderr
    )
    said = run("learn", *files, "--model", "rhythmic-dmp", "-o", tmp_path / "s.npz").stderr
    assert "warning: r3: misaligned" in said
    assert (tmp_path / "s.npz").exists()
    (cure,) = re.findall(r"or leave them out: leadthrough (.*)", said)
    assert cure.endswith("--align")
    assert "misaligned" not in run(*shlex.split(cure)).stderr


def test_a_clock_that_jumps_is_warned_of_without_that_cure(tmp_path):
    rows = reach()
    rows[75:, 0] += 3600.0
    files = [written(tmp_path, "jumps", rows)]
    said = run("learn", *files, "--model", "dmp", "-o", tmp_path / "s.npz").stderr
    assert "no sample from 1.49 to 3601.51 s" in said
    assert "--align" not in said


def standing_still():
    """How long the learned motion moves slower than a fiftieth of its highest speed, s."""
    motion = lt.load_skill("reach.npz").generate()
    speeds = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1) / np.diff(motion.times)
    return np.diff(motion.times)[speeds < 0.02 * speeds.max()].sum()


def test_a_learned_motion_does_not_stand_still(folder):
    told = run("learn", "recorded", "-o", "reach.npz").stderr
    assert told.count("stood still, left out") == 3
    assert standing_still() < 0.2
    run("learn", "recorded", "--rest", "inf", "-o", "reach.npz")
    assert standing_still() > 0.8


def test_many_recordings_are_told_of_in_one_line(folder):
    many = [f"recorded/reach{1 + number % 3}.csv" for number in range(9)]
    told = run("learn", *many, "-o", "reach.npz").stderr
    assert told.count("stood still") == 1
    assert "9 recordings: stood still, left out up to 1.54 s of each (--rest)" in told


def test_speed_and_rest_are_options(folder):
    run("learn", "recorded", "--rest", "0.4", "-o", "reach.npz")
    assert standing_still() > 0.5
    assert "--speed: " in run("learn", "recorded", "--speed", "-1", "-o", "x.npz", code=2).stderr
    assert "--rest: " in run("learn", "recorded", "--rest", "-1", "-o", "x.npz", code=2).stderr


def test_a_cleaned_recording_begins_with_the_motion(folder):
    (found,) = facts("clean", "recorded/reach1.csv", "-o", "clean.csv")
    assert min(found["report"]["still"]) > 0.2
    (found,) = facts("clean", "recorded/reach1.csv", "--rest", "inf", "-o", "clean.csv")
    assert found["report"]["still"] == [0.0, 0.0]
    (found,) = facts("clean", "recorded/reach1.csv", "--pause", "9", "-o", "clean.csv")
    assert found["report"]["pauses"] == []


def test_the_learned_motions_are_compared_with_each_recording(folder):
    said = run("learn", "recorded", "-o", "reach.npz").stdout
    assert re.search(r"left out errors aligned-mean \d\.\d+%, .*promp", " ".join(said.split()))
    assert re.search(r"within \d.* mm and 0\.\d+ degrees of reach1 \.\. reach3", said)
    assert re.search(
        r"within 0\.0\d+ rad", run("learn", "recorded", "--joints", "-o", "j.npz").stdout
    )
    assert "left out errors: aligned-mean" in run("info", "reach.npz").stdout
    near = facts("learn", "recorded", "-o", "reach.npz")["reproduction"]
    assert 0.0 < near["position"] < 2e-3
    assert 0.0 < near["orientation"] < 0.01
    assert 0.0 < near["fraction"] < 0.01


def test_a_recording_that_is_learned_badly_comes_with_the_cure(empty_folder):
    t = np.linspace(0.0, 10.0, 2000)
    many = np.column_stack([t, 0.1 * t, np.sin(12.0 * t), 0.2 * np.cos(12.0 * t)])
    words = ("learn", written(empty_folder, "spiral", many), "-o", "s.npz")
    said = run(*words, "--model", "dmp", "--set", "weights=10").stdout
    (cure,) = re.findall(r"next: leadthrough (.*)", said)
    assert cure.startswith("learn")
    again = run(*cure.split())
    assert "next: leadthrough plan s.npz" in again.stdout


def test_drawings_are_compared_in_their_own_unit(empty_folder):
    t = np.linspace(0.0, 1.0, 100)
    drawn = np.column_stack([t, 40.0 * t, 20.0 * t**2])
    shown = written(empty_folder, "drawing", drawn, header="t,x,y")
    said = run("learn", shown, "--column", "positions=x,y", "-o", "s.npz").stdout
    assert re.search(r"within [\d.e-]+ of drawing", said)


def recorded_otherwise(folder, name, change):
    """The example's reach2 under another name, its table (n, 7) of times and joints changed."""
    header = (folder / "recorded/reach2.csv").read_text().splitlines()[0]
    rows = np.loadtxt(folder / "recorded/reach2.csv", delimiter=",", skiprows=1)
    return written(folder / "recorded", name, change(rows), header=header)


def reversed_(rows):
    return np.column_stack([rows[:, 0], rows[::-1, 1:]])


def of_another_task(rows):
    swing = np.sin(np.outer(rows[:, 0], np.arange(2, 8)))
    return np.column_stack([rows[:, 0], rows[0, 1:] + 0.4 * swing])


def ten_times_as_fast(rows):
    return np.column_stack([0.1 * rows[:, 0], rows[:, 1:]])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (reversed_, "runs backwards"),
        (of_another_task, "takes a path of its own"),
        (ten_times_as_fast, "times its speed limit"),
    ],
)
def test_a_recording_that_contradicts_the_others_is_named_with_the_command_that_drops_it(
    folder, change, said
):
    recorded_otherwise(folder, "odd", change)
    (folder / "recorded/reach2.csv").unlink()
    refused = run("learn", "recorded", "-o", "s.npz", code=1)
    assert re.search(rf"odd: .*{said}", refused.stderr)
    assert not (folder / "s.npz").exists()
    (cure,) = re.findall(r"next: leadthrough (.*)", refused.stdout)
    assert cure.endswith("--drop odd")
    assert re.search("demonstrations +reach1, reach3", run(*cure.split()).stdout)


def test_noise_of_encoders_is_no_speed(folder):
    limits = (folder / "ur3.toml").read_text()
    (folder / "ur3.toml").write_text(re.sub(r"velocity = [\d.]+", "velocity = 0.6", limits))
    rng = np.random.default_rng(0)
    recorded_otherwise(
        folder,
        "odd",
        lambda rows: rows + 8e-3 * rng.normal(size=rows.shape) * [0, 1, 1, 1, 1, 1, 1],
    )
    run("learn", "recorded/odd.csv", "-o", "s.npz")


def test_a_recording_to_drop_has_a_name_that_was_read(folder):
    said = run("learn", "recorded", "--drop", "reach9", "-o", "s.npz", code=2).stderr
    assert "--drop: expected one of 'reach1'" in said


def test_a_pace_ten_times_as_high_is_named_without_an_arm(empty_folder):
    files = [
        written(empty_folder, f"r{i}", reach() * [f, 1, 1, 1]) for i, f in enumerate((1, 0.1, 1))
    ]
    said = run("learn", *files, "-o", "s.npz", code=1).stderr
    assert "r1: is 10 times as fast as the others" in said


def test_a_long_recording_is_learned_by_the_family_that_reproduces_it(empty_folder):
    t = np.linspace(0.0, 60.0, 3000)
    many = np.column_stack([t, 0.02 * t, np.sin(4.0 * t), 0.2 * np.cos(4.0 * t)])
    found = facts("learn", written(empty_folder, "long", many), "-o", "s.npz")
    assert found["model"] == "aligned-mean"
    assert "left_out_errors" not in found
    assert found["reproduction"]["fraction"] < 0.01
    assert type(lt.load_skill("s.npz").model) is lt.AlignedMean


def test_how_much_noise_of_the_recordings_is_smoothed_is_printed(tmp_path):
    times = np.linspace(0.0, 2.0, 201)
    u = times / 2.0
    points = np.column_stack([u, np.sin(3.0 * u), u**2])
    rng = np.random.default_rng(0)
    for name, noise in (("steady", 0.0), ("shaken", 2e-4)):
        rows = np.column_stack([times, points + noise * rng.normal(size=points.shape)])
        write_table(tmp_path / f"{name}.csv", "time,x,y,z", rows)
    skill = tmp_path / "skill.npz"
    shaken = facts("learn", tmp_path / "shaken.csv", "--model", "dmp", "-o", skill)
    assert shaken["smoothed"] == pytest.approx(2e-4, rel=0.2)
    said = run("learn", tmp_path / "shaken.csv", "--model", "dmp", "-o", skill).output
    assert "smoothed" in said
    assert "mm" in said
    assert "smoothed" not in facts("learn", tmp_path / "steady.csv", "--model", "dmp", "-o", skill)
