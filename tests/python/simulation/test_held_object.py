"""Two simulated arms with one object, welded to both hands."""

import numpy as np
import pytest
from motions import two_pandas
from refusals import refused

import leadthrough as lt
from leadthrough.simulation import Disturbances, simulate_held, simulated_arm

MASS, GRAVITY = 2.0, np.array([0.0, 0.0, -9.81])
DOWN = (0.0, 1.0, 0.0, 0.0)
GRASPS = (((0.0, 0.2, 0.0), DOWN), ((0.0, -0.2, 0.0), DOWN))
TRAY = lt.Box((0.25, 0.38, 0.02), (0.0, 0.0, -0.01))


@pytest.fixture(scope="module")
def held():
    return lt.arm.HeldObject(two_pandas().with_object(TRAY, GRASPS, mass=MASS), GRASPS)


@pytest.fixture(scope="module")
def lift(held):
    """Up by 0.2 m, forwards by 0.2, in 2 s."""
    times = np.linspace(0.0, 2.0, 101)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 2.0)
    path = np.column_stack([0.35 + 0.2 * s, np.full(101, -0.4), 0.25 + 0.2 * s])
    return lt.PoseTrajectory(times, path, np.tile([1.0, 0.0, 0.0, 0.0], (101, 1)))


@pytest.fixture(scope="module")
def run(held, lift):
    return lt.keep_timing(held.follow(lift), held.limits, rate=1000.0)


@pytest.fixture(scope="module")
def ideal(held, run):
    return simulate_held(held, run, disturbances=Disturbances.ideal())


def test_the_hands_carry_the_object_as_newton_says(lift, ideal):
    """Both forces together are its mass times its acceleration without gravity's."""
    times = ideal.simulated.times
    inside = (times > 0.1) & (times < lift.times[-1] - 0.1)
    s = times[inside] / 2.0
    second = (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / 4.0  # of the minimum-jerk polynomial
    wanted = MASS * (np.outer(second, [0.2, 0.0, 0.2]) - GRAVITY)
    together = ideal.forces.sum(axis=1)[inside]
    assert np.linalg.norm(together - wanted, axis=1).max() < 0.03 * MASS * 9.81
    at_rest = ideal.forces[-1]
    np.testing.assert_allclose(at_rest.sum(axis=0), -MASS * GRAVITY, atol=0.01)
    assert np.linalg.norm(at_rest[0] - at_rest[1]) < 1.0


def test_hands_that_keep_their_distance_hardly_press_the_object(ideal):
    assert ideal.relative_errors.max() < 2e-4
    assert ideal.relative_angles.max() < 1e-3
    assert np.abs(ideal.planned.positions - ideal.simulated.positions).max() < 1e-3
    assert ideal.inner_forces[100:].max() < 1.0


def test_hands_half_a_millimetre_too_near_press_it(held, run, ideal):
    """The right arm's motion is that of a grasp 0.5 mm nearer."""
    nearer = (GRASPS[0], ((0.0, -0.1995, 0.0), DOWN))
    shown = held.poses(run)
    off = held.pair.follow(shown, nearer)
    off = lt.keep_timing(off, held.limits, rate=1000.0)
    pressed = simulate_held(held, off, disturbances=Disturbances.ideal())
    assert pressed.inner_forces[-1] > 10.0 * ideal.inner_forces[-1] + 0.1
    assert pressed.relative_errors[200:].max() < 2e-4  # the welds hold


def test_real_drives_are_the_default_and_runs_are_equal_to_the_bit(held, run, ideal):
    real, again = (simulate_held(held, run) for _ in range(2))
    np.testing.assert_array_equal(real.simulated.positions, again.simulated.positions)
    away = np.abs(real.planned.positions - real.simulated.positions).max()
    assert 1e-4 < away < 0.02
    assert "inner forces up to" in str(real)


def test_wrong_arguments_are_named(held, run):
    empty = lt.arm.HeldObject(two_pandas(), GRASPS)
    refused("held: expected a pair with an object that has a mass", simulate_held, empty, run)
    refused("held: expected a HeldObject", simulate_held, held.pair, run)
    refused("rate", simulate_held, held, run, rate=10.0)
    refused("trajectory: expected", simulate_held, held, run.positions)


def test_a_joint_that_runs_away_is_named(held, run, monkeypatch):
    """With the bound lowered to a speed that the motion has, as torque limits keep joints slow."""
    monkeypatch.setattr(simulated_arm, "RUNAWAY", 0.05)
    with pytest.raises(FloatingPointError, match=r"panda_joint\d runs away after 0\.\d+ s"):
        simulate_held(held, run)
