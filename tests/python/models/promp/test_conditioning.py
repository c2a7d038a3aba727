"""Via points of ProMPs, in their columns, velocities or a task space, and limits."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

TIMES = np.linspace(0.0, 2.0, 200)


def test_conditioned_motion_passes_and_variance_nowhere_grows(skill):
    via = np.array([0.7, 0.9, 1.6])
    conditioned = skill.condition(1.0, via)
    mean, covariance = conditioned.distribution([1.0])
    np.testing.assert_allclose(mean[0], via, atol=1e-9)
    assert np.abs(covariance).max() < 1e-12
    _, before = skill.distribution(TIMES)
    _, after = conditioned.distribution(TIMES)
    assert np.linalg.eigvalsh(before - after).min() > -1e-12
    assert (np.einsum("nii->n", after) < np.einsum("nii->n", before)).mean() > 0.9


def test_several_via_points_hold_at_once_and_their_order_does_not_matter(skill):
    vias = {0.0: [0.1, 0.0, -0.1], 0.8: [0.5, 0.9, 1.0], 1.5: [0.9, 1.8, 2.6]}
    forth, back = skill, skill
    for time, via in vias.items():
        forth = forth.condition(time, via)
    for time, via in reversed(vias.items()):
        back = back.condition(time, via)
    mean, _ = forth.distribution(list(vias))
    np.testing.assert_allclose(mean, list(vias.values()), atol=1e-7)
    np.testing.assert_allclose(back.distribution(TIMES)[0], forth.distribution(TIMES)[0], atol=1e-6)


def test_via_points_may_be_given_at_once(skill):
    times, values = [0.4, 1.0, 1.6], np.array([[0.2, 0.1, 0.3], [0.5, 1.0, 1.5], [0.9, 1.7, 2.6]])
    one_by_one, noise = skill, 1e-4 * np.eye(3)
    for time, value in zip(times, values, strict=True):
        one_by_one = one_by_one.condition(time, value, covariance=noise)
    together = skill.condition(times, values, covariance=noise)
    for a, b in zip(together.distribution(TIMES), one_by_one.distribution(TIMES), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-8)
    exact = skill.condition(np.array(times), values)
    np.testing.assert_allclose(exact.distribution(times)[0], values, atol=1e-8)


@given(st.floats(0.0, 2.0), st.lists(st.floats(-2.0, 4.0), min_size=3, max_size=3))
def test_any_via_point_is_passed(skill, time, via):
    mean, _ = skill.condition(time, via).distribution([time])
    np.testing.assert_allclose(mean[0], via, atol=1e-8)


@pytest.mark.parametrize("basis", ["gaussian", "rhythmic"])
def test_noisy_via_points_have_the_bits_of_those_that_are_looked_at_one_by_one(shown, basis):
    skill = lt.ProMP(weights=9, basis=basis).fit(shown())
    noise, vias = np.diag([1e-4, 2e-4, 3e-4]), np.array([[0.5, 1.0, 1.6], [0.6, 1.3, 1.9]])
    times = np.array([0.6, 1.3])
    for quick, looked_at in (
        ((1.3, vias[1]), ([1.3], vias[1:].tolist())),
        ((times, vias), (times.tolist(), vias)),
    ):
        one = skill.condition(*quick, covariance=noise)
        other = skill.condition(*looked_at, covariance=noise.tolist())
        assert one.free.mean.tobytes() == other.free.mean.tobytes()
        assert one.free.covariance.tobytes() == other.free.covariance.tobytes()
        kept = [field.name for field in fields(one) if field.name != "free"]
        assert all(getattr(one, name) is getattr(other, name) for name in kept)
    for time, via, spread, word in (
        (np.nan, vias[0], noise, "time"),
        (0.6, vias[0] * np.nan, noise, "position"),
        (0.6, vias[0], -noise, "covariance"),
    ):
        refused(word, skill.condition, time, via, covariance=spread)


def test_noisy_observation_is_weighed_as_bayes_rule_says(skill):
    mean, covariance = (each[0] for each in skill.distribution([1.0]))
    noise = np.diag([0.1, 0.2, 0.3]) ** 2
    value = mean + np.array([0.2, -0.1, 0.3])
    after, _ = skill.condition(1.0, value, covariance=noise).distribution([1.0])
    expected = mean + covariance @ np.linalg.solve(covariance + noise, value - mean)
    np.testing.assert_allclose(after[0], expected, atol=1e-10)


def test_velocities_and_single_columns_can_be_given(skill):
    conditioned = skill.condition(0.5, [0.4], order=1, columns=[2]).condition(
        1.2, [0.7, 2.0], columns=[0, 2]
    )
    assert conditioned.distribution([0.5], order=1)[0][0, 2] == pytest.approx(0.4, abs=1e-8)
    np.testing.assert_allclose(conditioned.distribution([1.2])[0][0, [0, 2]], [0.7, 2.0], atol=1e-8)


@pytest.mark.parametrize(("order", "value"), [(1, 0.4), (2, -0.3)])
def test_a_derivative_that_is_asked_for_is_met(skill, order, value):
    made = skill.condition(0.8, [value], order=order, columns=[1]).generate(dt=0.01)
    rates = made.positions
    for _ in range(order):
        rates = np.gradient(rates, 0.01, axis=0)
    assert rates[80, 1] == pytest.approx(value, abs=2e-3)


def test_task_space_via_point_is_reached_by_the_mean(shown):
    def hand(q):  # of a planar arm with links of 1 m
        angles = np.cumsum(q)
        tip = [np.cos(angles).sum(), np.sin(angles).sum()]
        jacobian = [
            [-np.sin(angles[i:]).sum() for i in range(3)],
            [np.cos(angles[i:]).sum() for i in range(3)],
        ]
        return np.array(tip), np.array(jacobian)

    skill = lt.ProMP().fit(shown())
    tip, _ = hand(skill.distribution([1.0])[0][0])
    wanted = tip + np.array([0.15, -0.1])
    conditioned = skill.condition_task(1.0, wanted, hand)
    np.testing.assert_allclose(hand(conditioned.distribution([1.0])[0][0])[0], wanted, atol=1e-7)
    soft = skill.condition_task(1.0, wanted, hand, covariance=1e4 * np.eye(2))
    np.testing.assert_allclose(soft.distribution(TIMES)[0], skill.distribution(TIMES)[0], atol=1e-3)
    refused("reach", skill.condition_task, 1.0, [9.0, 0.0], hand)


def test_tool_of_an_arm_is_led_through_a_point_of_its_task_space(shown):
    panda = lt.Arm.load("panda")
    ready = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    moved = [
        lt.JointTrajectory(each.times, ready + 0.1 * each.positions) for each in shown(joints=7)
    ]
    skill = lt.ProMP().fit(moved)

    def tool(q):
        return panda.forward_kinematics(q)[0], panda.jacobian(q)[:3]

    wanted = tool(skill.distribution([1.0])[0][0])[0] + np.array([0.02, -0.03, 0.01])
    led = skill.condition_task(1.0, wanted, tool)
    np.testing.assert_allclose(tool(led.distribution([1.0])[0][0])[0], wanted, atol=1e-7)
    _, jacobian = tool(led.distribution([1.0])[0][0])
    spread = jacobian @ led.distribution([1.0])[1][0] @ jacobian.T
    assert np.abs(spread).max() < 1e-9  # the tool is there in every sample, to first order


def test_contradicting_via_points_are_refused(skill):
    fixed = skill.condition(1.0, [0.5, 1.0, 1.5])
    np.testing.assert_allclose(
        fixed.condition(1.0, [0.5, 1.0, 1.5]).weights.mean, fixed.weights.mean, atol=1e-9
    )
    for aside in (0.1, -0.1):
        refused("position", fixed.condition, 1.0, [0.5 + aside, 1.0, 1.5])
    refused("start", skill.condition(0.0, [0.0, 0.0, 0.1]).generate, start=[0.0, 0.0, 0.2])


@pytest.mark.parametrize("covariance", [None, np.eye(3)])
def test_no_via_points_at_all_are_refused(skill, covariance):
    refused("time: expected", skill.condition, [], np.empty((0, 3)), covariance=covariance)
    with pytest.raises(InvalidInput, match="value: expected at least one"):
        skill.condition_task(1.0, [], lambda q: (q[:0], np.empty((0, 3))))


def test_via_points_too_close_for_the_basis_are_refused_with_their_times(skill):
    mean = skill.distribution([1.0, 1.02])[0]
    apart = 0.3 * np.array([[1.0], [-1.0]]) * skill.scale
    with pytest.raises(InvalidInput, match=r"1 s and 1\.02 s; the 20 weights .* from 0\.\d+ s"):
        skill.condition([1.0, 1.02], mean + apart)
    first = skill.condition(1.0, mean[0] + apart[0])
    refused(r"1\.02 s right beside a point fixed before", first.condition, 1.02, mean[1] + apart[1])


@pytest.mark.parametrize("gap", [0.01, 0.25, 0.6])
def test_via_points_that_the_basis_resolves_do_not_throw_the_motion(skill, gap):
    times = [1.0, 1.0 + gap]
    together = skill.distribution(times)[0] + 0.3 * skill.scale
    before = skill.distribution(TIMES)[0]
    led = skill.condition(times, together)
    assert np.abs((led.distribution(TIMES)[0] - before) / skill.scale).max() < 5 * 0.3
    np.testing.assert_allclose(led.distribution(times)[0], together, atol=1e-6)


INF = np.inf
LIMITS = {
    "one joint from above": ([-INF] * 3, [1.0, INF, INF]),
    "two joints": ([-0.05, -INF, -INF], [1.0, 2.0, INF]),
    "all joints from both sides": ([-0.2] * 3, [1.0, 1.9, 3.1]),
}
FEW = np.linspace(0.0, 2.0, 41)


def kept(skill, lower, upper, least=5000):
    """Values (n, m, d) of motions drawn without limits, of which those that keep them are taken."""
    rng = np.random.default_rng(1)
    phases = np.linspace(0.0, 1.0, 81)
    rows = skill.basis(phases)
    inside = []
    while sum(map(len, inside)) < least:
        normal = rng.standard_normal((10_000, len(skill.free.mean)))
        weights = skill.free.mean + normal @ skill.free.root.T
        values = np.matmul(rows, weights.reshape(len(weights), skill.coordinates.width, -1).mT)
        inside.append(values[((values >= lower) & (values <= upper)).all(axis=(1, 2)), ::2])
    return np.concatenate(inside)


@pytest.mark.parametrize("limits", LIMITS.values(), ids=LIMITS)
def test_mean_covariance_and_samples_are_those_of_motions_that_keep_the_limits(skill, limits):
    limited = skill.within(*limits)
    truth = kept(skill, *limits)
    spread = truth.std(axis=0)
    mean, covariance = limited.distribution(FEW)
    assert (np.abs(mean - truth.mean(axis=0)) / spread).max() < 0.05
    deviations = np.sqrt(np.einsum("nii->ni", covariance)) / spread
    assert np.abs(deviations - 1.0).max() < 0.06
    np.testing.assert_allclose(limited.generate(dt=0.05).positions, mean, atol=1e-12)
    weights = limited.sample_weights(2000, seed=2).reshape(2000, 3, -1)
    drawn = np.matmul(skill.basis(FEW / 2.0), weights.mT)
    assert (np.abs(drawn.mean(axis=0) - mean) / spread).max() < 0.1
    assert np.abs(drawn.std(axis=0) / spread - 1.0).max() < 0.1
    for values in (mean, drawn):
        assert (values >= limits[0]).all()
        assert (values <= limits[1]).all()


def test_limits_far_below_the_mean_are_kept_too(skill):
    """No motion of the eight shown keeps them, nor would one in a million that are drawn."""
    limited = skill.within([-INF] * 3, [0.4, INF, INF])
    mean, covariance = limited.distribution(FEW)
    assert (mean[:, 0] <= 0.4).all()
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    assert (covariance[:, 0, 0] < 1.01 * skill.distribution(FEW)[1][:, 0, 0]).all()
    for motion in limited.sample(5, seed=0):
        assert (motion.positions[:, 0] <= 0.4 + 1e-9).all()


def test_what_is_observed_first_does_not_matter(skill):
    upper = [0.9, 1.9, INF]
    first = skill.within([-INF] * 3, upper).condition(1.0, [0.5, 1.0, 1.4])
    then = skill.condition(1.0, [0.5, 1.0, 1.4]).within([-INF] * 3, upper)
    np.testing.assert_array_equal(first.weights.mean, then.weights.mean)
    np.testing.assert_array_equal(first.weights.covariance, then.weights.covariance)


def test_a_start_asked_for_is_met_inside_the_limits(skill):
    limited = skill.within([-INF] * 3, [0.9, 1.9, INF])
    start = skill.generate().positions[0] + 0.02
    moved = limited.generate(start=start).positions
    np.testing.assert_allclose(moved[0], start, atol=1e-9)
    assert (moved <= [0.9, 1.9, INF]).all()
