"""What is asked too large is refused with its size, before it takes the memory."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput

VAST = np.broadcast_to(np.float64(1.0), (10**6, 10**6))  # takes eight bytes itself


@pytest.fixture(scope="module")
def demonstrations():
    times = np.linspace(0.0, 1.0, 50)
    return [lt.Demonstration(lt.Trajectory(times, np.column_stack([times, times**2])))] * 3


@pytest.fixture(scope="module")
def promp(demonstrations):
    return lt.ProMP().fit(demonstrations)


@pytest.mark.parametrize("count", [10**6, 10**12, 10**30])
def test_a_million_motions_at_once_are_refused_with_their_size(promp, count):
    with pytest.raises(InvalidInput, match=rf"count: .* got {count:,}, which would take .* GiB"):
        promp.sample(count, seed=0)


def test_points_of_a_mixture_are_counted_too(demonstrations):
    mixture = lt.GMR(components=2).fit(demonstrations).mixture
    with pytest.raises(InvalidInput, match=r"count: expected at most .*, got 1,000,000,000"):
        mixture.sample(10**9, seed=0)
    assert mixture.sample(1000, seed=0).shape == (1000, 3)


@pytest.mark.parametrize("count", [0, 1_000_001])
@pytest.mark.parametrize("model", [lt.ProMP(), lt.GMR(components=2)], ids=["ProMP", "GMR"])
def test_a_distribution_at_no_or_too_many_times_is_refused(demonstrations, model, count):
    skill = model.fit(demonstrations)
    with pytest.raises(InvalidInput, match=rf"times: expected 1 to 1,000,000 times, got {count:,}"):
        skill.distribution(np.zeros(count))


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: lt.Grid((0, 0), 1.0, (10**20, 10**20)), "shape: expected at most 2e"),
        (lambda: lt.arrival_times(VAST, [(0, 0)]), "speed: expected at most 2e"),
        (lambda: lt.planning.distance_transform(np.broadcast_to(True, VAST.shape)), "mask"),
        (lambda: lt.Arm.load("ur3").forward_kinematics(np.broadcast_to(0.0, (10**14, 6))), "q: an"),
        (lambda: lt.Trajectory(np.broadcast_to(0.0, (10**15,)), [[0.0]]), "times: an array"),
    ],
)
def test_a_grid_or_an_array_too_large_is_named(call, named):
    with pytest.raises(InvalidInput, match=named):
        call()


def test_held_joints_have_names():
    with pytest.raises(InvalidInput, match="locked_joints: expected a joint's name, got 0"):
        lt.Arm.load("ur3").lock_joints({0: 1e9})
    with pytest.raises(InvalidInput, match="locked_joints: elbow_joint: expected a value inside"):
        lt.Arm.load("ur3").lock_joints({"elbow_joint": 1e9})


def test_a_skill_whose_head_nests_deep_is_refused(tmp_path):
    np.savez(tmp_path / "deep.npz", head=np.array("[" * 100_000))
    with pytest.raises(InvalidInput, match="path: expected a saved skill"):
        lt.load_skill(tmp_path / "deep.npz")
