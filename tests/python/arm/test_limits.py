import numpy as np
import pytest
from refusals import refused

from leadthrough.arm import JointLimits, read_limits
from leadthrough.errors import InvalidInput

NAMES = ("one", "two")
URDF = JointLimits(NAMES, [-1, -2], [1, 2], [3, 3], effort=[10, 10])


@pytest.fixture
def toml(tmp_path):
    def write(text):
        path = tmp_path / "limits.toml"
        path.write_text(text)
        return path

    return write


def test_the_file_overrides_and_completes_the_urdf(toml):
    path = toml(
        'robot = "r"\n[sources]\nvelocity = "a book"\n[joints]\n'
        "one = { velocity = 1.5, acceleration = 5, jerk = 50, lower = -0.5 }\n"
        "two = { acceleration = 6, jerk = 60 }\n"
    )
    limits = read_limits(path, URDF)
    np.testing.assert_array_equal(limits.lower, [-0.5, -2])
    np.testing.assert_array_equal(limits.velocity, [1.5, 3])
    np.testing.assert_array_equal(limits.acceleration, [5, 6])
    np.testing.assert_array_equal(limits.jerk, [50, 60])
    np.testing.assert_array_equal(limits.effort, [10, 10])


def test_what_nobody_states_stays_unknown(toml):
    limits = read_limits(toml("[joints]\none = { velocity = 1 }\n"), URDF)
    assert limits.acceleration is None
    assert limits.jerk is None


def test_joints_outside_the_arm_may_be_spoken_of(toml):
    path = toml("[joints]\nfinger = { velocity = 1 }\n")
    read_limits(path, URDF, other_joints=["finger"])
    refused("unknown joint 'finger'", read_limits, path, URDF)


def test_a_wrong_file_is_refused_with_the_place(toml):
    for text, message in [
        ("[joints", "not a TOML document"),
        ("", r"\[joints\]"),
        ("joints = 3", r"\[joints\]"),
        ("[joints]\none = 3", r"\[one\]"),
        ("[joint]\none = { velocity = 1 }", "got 'joint'"),
        ("[joints]\none = { speed = 1 }", "got 'speed'"),
        ("[joints]\none = { velocity = -1 }", "one: velocity"),
        ("[joints]\none = { velocity = nan }", "one: velocity"),
        ('[joints]\none = { velocity = "fast" }', "one: velocity"),
        ("[joints]\none = { acceleration = 1 }", "two: expected acceleration"),
        ("[joints]\none = { lower = 2 }", "lower: expected at most upper for 'one'"),
    ]:
        refused(message, read_limits, toml(text), URDF)
    for path in ["nowhere.toml", None, 3]:
        refused("cannot read", read_limits, path, URDF)


@pytest.mark.parametrize(
    "change",
    [
        {"lower": [2, 0]},
        {"lower": [np.nan, 0]},
        {"velocity": [-1, 1]},
        {"velocity": [1]},
        {"jerk": ["a", 1]},
        {"effort": [[1, 2], [3]]},
    ],
)
def test_contradictory_limits_are_refused(change):
    values = {"lower": [-1, -1], "upper": [1, 1], "velocity": [1, 1]} | change
    with pytest.raises(InvalidInput):
        JointLimits(NAMES, **values)


def test_limits_are_read_only_copies():
    lower = np.array([-1.0, -1.0])
    limits = JointLimits(NAMES, lower, [1, 1], [1, 1])
    lower[0] = 5
    assert limits.lower[0] == -1
    with pytest.raises(ValueError, match="read-only"):
        limits.lower[0] = 0


def test_a_template_becomes_a_limits_file(toml):
    template = URDF.template()
    assert template.count("?") == 4
    limits = read_limits(toml(template.replace("?", "7.5")), URDF)
    np.testing.assert_array_equal(limits.velocity, URDF.velocity)
    np.testing.assert_array_equal(limits.acceleration, [7.5, 7.5])
    np.testing.assert_array_equal(limits.jerk, [7.5, 7.5])


def test_a_template_of_odd_names_is_toml_as_well(toml):
    names = ('a "b"', "tür\n")
    odd = JointLimits(names, [-1, -1], [1, 1], [1, np.inf], [2, 3], [4, 5])
    limits = read_limits(toml(odd.template().replace("?", "9")), odd)
    np.testing.assert_array_equal(limits.velocity, [1, 9])
    np.testing.assert_array_equal(limits.jerk, [4, 5])


def test_limits_of_the_other_joints():
    rest = URDF.without({"one"})
    assert rest.joint_names == ("two",)
    np.testing.assert_array_equal(rest.upper, [2])
    assert rest.acceleration is None
