import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from motions import with_derivatives
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import joint_trajectory

NAMES = ("shoulder_pan_joint", "wrist_1_joint")
TIMES = 7.0 + np.linspace(0.0, 2.0, 41) ** 1.5
PLAIN = lt.JointTrajectory(
    TIMES, np.column_stack([np.sin(TIMES), TIMES**2 / 30]), joint_names=NAMES
)
FULL = with_derivatives(PLAIN)


def seconds(stamp):
    assert 0 <= stamp["nanosec"] < 1_000_000_000
    return stamp["sec"] + 1e-9 * stamp["nanosec"]


def test_csv_has_the_derivatives_that_the_trajectory_has(tmp_path):
    lt.write_motion(FULL, tmp_path / "arm.csv")
    columns = {"joints": [f"{name}_velocity" for name in NAMES]}
    motion = lt.read_motion(tmp_path / "arm.csv", columns=columns)
    assert np.array_equal(motion.positions, FULL.velocities)
    lt.write_motion(PLAIN, tmp_path / "arm.csv")
    with pytest.raises(InvalidInput, match="no column 'shoulder_pan_joint_velocity'"):
        lt.read_demonstrations(tmp_path / "arm.csv", columns=columns)


def test_json_is_a_message_that_the_controller_takes(tmp_path):
    joint_trajectory.write_json(FULL, tmp_path / "arm.json")
    message = json.loads((tmp_path / "arm.json").read_text())
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert message["joint_names"] == list(NAMES)
    points = message["points"]
    fields = {"positions", "velocities", "accelerations", "effort", "time_from_start"}
    assert all(point.keys() == fields for point in points)
    for name in ("positions", "velocities", "accelerations"):
        np.testing.assert_array_equal([point[name] for point in points], getattr(FULL, name))
    times = np.array([seconds(point["time_from_start"]) for point in points])
    assert times[0] > 0
    assert (np.diff(times) > 0).all()
    np.testing.assert_allclose(times, TIMES - TIMES[0] + (TIMES[1] - TIMES[0]), atol=1e-9)
    assert points[0]["velocities"] == points[-1]["velocities"] == [0.0, 0.0]


def test_json_rounds_a_rest_that_is_almost_one(tmp_path):
    velocities = FULL.velocities.copy()
    velocities[[0, -1]] = 9e-4
    joint_trajectory.write_json(replace(FULL, velocities=velocities), tmp_path / "arm.json")
    points = json.loads((tmp_path / "arm.json").read_text())["points"]
    assert points[0]["velocities"] == points[-1]["velocities"] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("trajectory", "message"),
    [
        (replace(FULL, joint_names=()), "expected joint_names, which the robot needs, got none"),
        (replace(FULL, joint_names=("a", "a")), "expected different, printable joint_names"),
        (replace(FULL, joint_names=("a", "")), "expected different, printable joint_names"),
        (replace(FULL, joint_names=("a", "b\n")), "expected different, printable joint_names"),
        (replace(FULL, velocities=None), "expected velocities, got none"),
        (replace(FULL, velocities=np.ones((41, 2))), "rest at the first sample, got 1 rad/s"),
        (
            replace(FULL, velocities=np.linspace([0, 0], [1, 0], 41)),
            "rest at the last sample, got 1 rad/s",
        ),
        (replace(FULL, times=np.arange(41) * 1e-10), "at least a nanosecond apart"),
        (replace(FULL, times=np.arange(41) * 1e9), r"duration below 2\*\*31 s"),
        (lt.JointTrajectory([0], [[0.0]], [[0.0]], joint_names=("a",)), "at least two samples"),
        (lt.Trajectory([0, 1], [[0.0], [1.0]]), "expected a JointTrajectory, got Trajectory"),
    ],
)
def test_json_refuses_what_no_robot_could_execute(tmp_path, trajectory, message):
    refused(message, joint_trajectory.write_json, trajectory, tmp_path / "arm.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "write", [partial(lt.write_motion, format="csv"), joint_trajectory.write_json]
)
def test_a_path_that_cannot_be_written_is_refused(tmp_path, write):
    refused("path: no such folder", write, FULL, tmp_path / "missing" / "arm.out")
    refused(r"path: .* cannot be written", write, FULL, tmp_path)
    refused("path: ", write, FULL, None)
