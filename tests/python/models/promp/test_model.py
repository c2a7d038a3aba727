"""ProMPs by least squares: the distribution, conditioning, samples, likelihood."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import Gaussian, product
from leadthrough.models.promp.prior import smooth_prior

TIMES = np.linspace(0.0, 2.0, 200)


def shown(count=8, *, joints=3, noise=0.0, seed=0, duration=2.0):
    """Smooth joint motions whose amplitudes and offsets vary."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 200)
    swing = 10 * u**3 - 15 * u**4 + 6 * u**5
    demonstrations = []
    for _ in range(count):
        ends = np.arange(1, joints + 1) * (1.0 + 0.2 * rng.standard_normal(joints))
        bump = 0.3 * rng.standard_normal(joints)
        q = np.outer(swing, ends) + np.outer(np.sin(np.pi * u), bump)
        q = q + noise * rng.standard_normal(q.shape)
        motion = lt.JointTrajectory(duration * u, q, joint_names=tuple("abcdefg"[:joints]))
        demonstrations.append(lt.Demonstration(motion))
    return demonstrations


@pytest.fixture(scope="module")
def skill():
    return lt.ProMP().fit(shown())


def test_mean_and_spread_are_those_of_the_demonstrations():
    demonstrations = shown(40)
    mean, covariance = lt.ProMP().fit(demonstrations).distribution(TIMES)
    curves = np.stack([each.motion.positions for each in demonstrations])
    np.testing.assert_allclose(mean, curves.mean(axis=0), atol=1e-3)
    deviation = np.sqrt(np.einsum("nii->ni", covariance))
    np.testing.assert_allclose(deviation, curves.std(axis=0, ddof=1), atol=0.05)


@pytest.mark.parametrize("count", [6, 60])
def test_known_distribution_is_recovered_as_well_as_by_the_sample_covariance(count):
    basis, size = Basis("gaussian", 8), 2
    truth = smooth_prior(basis, np.array([0.3, 0.5]))
    u = np.linspace(0.0, 1.0, 60)
    rows = np.kron(np.eye(size), basis(u))
    middle = np.concatenate([np.linspace(0, 2, 8), np.linspace(1, -1, 8)])
    ours, samples = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        weights = rng.multivariate_normal(middle, truth, count)
        curves = (weights @ rows.T).reshape(count, size, -1).transpose(0, 2, 1)
        given = [lt.Demonstration(lt.Trajectory(2 * u, curve)) for curve in curves]
        fitted = lt.ProMP(weights=8).fit(given).weights.covariance
        ours.append(np.linalg.norm(fitted - truth))
        samples.append(np.linalg.norm(np.cov(weights.T) - truth))
    assert np.mean(ours) <= 1.1 * np.mean(samples)


def test_velocity_and_acceleration_are_derivatives_of_the_mean(skill):
    step = 1e-5
    inside = TIMES[1:-1]
    for order in (1, 2):
        ahead, _ = skill.distribution(inside + step, order=order - 1)
        behind, _ = skill.distribution(inside - step, order=order - 1)
        given, _ = skill.distribution(inside, order=order)
        np.testing.assert_allclose(given, (ahead - behind) / (2 * step), atol=1e-4)


def test_covariances_are_those_of_samples(skill):
    times = np.linspace(0.0, 2.0, 9)
    weights = skill.sample_weights(20_000, seed=1).reshape(20_000, 3, -1)
    for order in (0, 1, 2):
        rows = skill.basis(times / 2.0, order) / 2.0**order
        values = np.einsum("nk,mdk->mnd", rows, weights)
        _, covariance = skill.distribution(times, order=order)
        for i in range(len(times)):
            tolerance = 0.05 * np.abs(covariance[i]).max()
            np.testing.assert_allclose(np.cov(values[:, i].T), covariance[i], atol=tolerance)


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


def test_task_space_via_point_is_reached_by_the_mean():
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
    with pytest.raises(InvalidInput, match="reach"):
        skill.condition_task(1.0, [9.0, 0.0], hand)


def test_tool_of_an_arm_is_led_through_a_point_of_its_task_space():
    panda = lt.Arm.load("panda")
    ready = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    moved = [
        lt.Demonstration(lt.JointTrajectory(each.motion.times, ready + 0.1 * each.motion.positions))
        for each in shown(joints=7)
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
    with pytest.raises(InvalidInput, match="position"):
        fixed.condition(1.0, [0.6, 1.0, 1.5])
    with pytest.raises(InvalidInput, match="start"):
        skill.condition(0.0, [0.0, 0.0, 0.1]).generate(start=[0.0, 0.0, 0.2])


def test_joint_motion_comes_with_names_and_derivatives(skill):
    motion = skill.generate(duration=4.0, dt=0.005)
    assert isinstance(motion, lt.JointTrajectory)
    assert motion.joint_names == ("a", "b", "c")
    gradient = np.gradient(motion.positions, motion.times, axis=0)
    np.testing.assert_allclose(motion.velocities[1:-1], gradient[1:-1], atol=1e-3)
    slope = np.gradient(motion.velocities, motion.times, axis=0)
    np.testing.assert_allclose(motion.accelerations[1:-1], slope[1:-1], atol=1e-2)


def test_samples_are_repeatable_and_of_the_type_shown(skill):
    first, second = (skill.sample(3, seed=7) for _ in range(2))
    assert len(first) == 3
    for a, b in zip(first, second, strict=True):
        assert isinstance(a, lt.JointTrajectory)
        assert a.positions.tobytes() == b.positions.tobytes()
    assert skill.sample(1, seed=8)[0].positions.tobytes() != first[0].positions.tobytes()


def test_likelihood_is_that_of_the_normal_distribution():
    skill = lt.ProMP(weights=6).fit(shown(noise=0.02))
    motion = shown(1, seed=9, noise=0.02)[0].motion
    rows = np.kron(np.eye(3), skill.basis(motion.times / motion.duration))
    covariance = rows @ skill.weights.covariance @ rows.T
    covariance += np.kron(np.diag(skill.noise), np.eye(200))
    residual = motion.positions.T.ravel() - rows @ skill.weights.mean
    _, volume = np.linalg.slogdet(2 * np.pi * covariance)
    expected = -0.5 * (residual @ np.linalg.solve(covariance, residual) + volume)
    assert skill.log_likelihood(motion) == pytest.approx(expected, rel=1e-8)


def test_likelihood_tells_alike_from_strange_and_ignores_duration():
    skill = lt.ProMP().fit(shown(noise=0.01))
    alike = shown(1, seed=5, noise=0.01)[0].motion
    slow = shown(1, seed=5, noise=0.01, duration=6.0)[0].motion
    strange = lt.JointTrajectory(alike.times, alike.positions[::-1])
    assert skill.log_likelihood(alike) > skill.log_likelihood(strange)
    assert skill.log_likelihood(slow) == pytest.approx(skill.log_likelihood(alike))


def test_limits_hold_for_mean_and_samples_and_via_points_stay(skill):
    upper = [0.8, 1.9, np.inf]
    limited = skill.condition(1.0, [0.5, 1.0, 1.4]).within([-0.2, -np.inf, -np.inf], upper)
    for motion in (limited.generate(), *limited.sample(5, seed=0)):
        assert (motion.positions <= np.array(upper) + 1e-6).all()
        assert (motion.positions[:, 0] >= -0.2 - 1e-6).all()
    np.testing.assert_allclose(limited.distribution([1.0])[0][0], [0.5, 1.0, 1.4], atol=1e-6)
    moved = limited.condition(0.4, [0.6, 0.5, 0.4])
    assert (moved.generate().positions <= np.array(upper) + 1e-6).all()


def test_limits_that_nothing_touches_change_nothing(skill):
    limited = skill.within([-100.0] * 3, [100.0] * 3)
    np.testing.assert_array_equal(limited.weights.mean, skill.weights.mean)


def test_limits_that_a_via_point_breaks_are_refused(skill):
    fixed = skill.condition(1.0, [0.5, 1.0, 1.4])
    with pytest.raises(InvalidInput, match="limits"):
        fixed.within([-1.0] * 3, [0.4, 9.0, 9.0])


def test_moved_inside_is_the_nearest_in_the_covariances_measure():
    skill = lt.ProMP(weights=8).fit(shown())
    limited = skill.within([-9.0] * 3, [0.9, 9.0, 9.0])
    step = limited.weights.mean - skill.weights.mean
    cost = step @ np.linalg.solve(skill.weights.covariance, step)
    rng = np.random.default_rng(0)
    rows = np.kron([1.0, 0.0, 0.0], skill.basis(np.linspace(0, 1, 81)))
    for _ in range(200):
        other = limited.weights.mean + 0.02 * skill.weights.root @ rng.standard_normal(24)
        if (rows @ other <= (rows @ limited.weights.mean).max()).all():
            away = other - skill.weights.mean
            assert away @ np.linalg.solve(skill.weights.covariance, away) >= cost - 1e-6


def test_duration_scales_velocities(skill):
    slow = skill.lasting(4.0)
    np.testing.assert_allclose(slow.distribution(2 * TIMES)[0], skill.distribution(TIMES)[0])
    np.testing.assert_allclose(
        slow.distribution(2 * TIMES, order=1)[0],
        0.5 * skill.distribution(TIMES, order=1)[0],
        atol=1e-12,
    )


def test_rhythmic_motion_closes_and_repeats():
    u = np.linspace(0.0, 1.0, 150)
    circle = [
        lt.Demonstration(
            lt.Trajectory(
                3 * u, r * np.column_stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)])
            )
        )
        for r in (0.9, 1.0, 1.1)
    ]
    skill = lt.ProMP(basis="rhythmic", weights=12).fit(circle)
    times = np.linspace(0.0, 3.0, 50)
    for order in (0, 1, 2):
        first, _ = skill.distribution(times, order=order)
        np.testing.assert_allclose(
            skill.distribution(times + 6.0, order=order)[0], first, atol=1e-8
        )
    np.testing.assert_allclose(np.linalg.norm(skill.distribution(times)[0], axis=1), 1.0, atol=1e-3)
    assert "goal" not in skill.supports
    with pytest.raises(UnsupportedQuery, match="goal"):
        skill.generate(goal=(1.0, 0.0))


@pytest.mark.parametrize("estimator", ["least_squares", "em"])
def test_tiny_and_singular_sets_give_usable_models(estimator):
    demonstrations = shown(1)
    still = np.array(demonstrations[0].motion.positions)
    still[:, 1] = 0.4
    constant = [lt.Demonstration(lt.JointTrajectory(TIMES, still + 0.01 * i)) for i in range(2)]
    for several in (demonstrations, 3 * demonstrations, constant):
        skill = lt.ProMP(estimator=estimator).fit(several)
        via = skill.distribution([1.0])[0][0] + 0.05
        motion = skill.condition(1.0, via).generate(start=(0.1, 0.4, 0.1))
        np.testing.assert_allclose(motion.positions[0], (0.1, 0.4, 0.1), atol=1e-6)
        np.testing.assert_allclose(motion.positions[100], via, atol=1e-6)
        assert np.isfinite(skill.log_likelihood(several[0].motion))
        assert len(skill.sample(2, seed=0)) == 2


def test_few_samples_are_enough():
    u = np.linspace(0.0, 1.0, 4)
    few = [lt.Demonstration(lt.Trajectory(u, np.column_stack([u, a * u]))) for a in (0.9, 1.1)]
    mean, _ = lt.ProMP().fit(few).distribution(np.linspace(0, 1, 30))
    np.testing.assert_allclose(mean[:, 1], mean[:, 0], atol=0.02)


def test_parts_are_refused_with_the_way_out():
    demonstrations = shown(2)
    with pytest.raises(FitError, match="em"):
        lt.ProMP().fit(demonstrations, phases=[np.linspace(0, 1, 200), np.linspace(0.5, 1, 200)])


def test_skill_with_limits_and_joints_is_saved(skill, tmp_path):
    limited = skill.within([-9.0] * 3, [1.0, np.inf, 9.0])
    limited.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert loaded.chart.joint_names == ("a", "b", "c")
    assert loaded.generate().positions.tobytes() == limited.generate().positions.tobytes()
    for a, b in zip(loaded.bounds, limited.bounds, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda s: s.distribution([2.5]), "times"),
        (lambda s: s.distribution([0.0], order=3), "order"),
        (lambda s: s.condition(1.0, [1.0]), "position"),
        (lambda s: s.condition(np.nan, [0.0] * 3), "time"),
        (lambda s: s.condition(1.0, [0.0] * 3, covariance=-np.eye(3)), "covariance"),
        (lambda s: s.condition(1.0, [0.0], columns=[3]), "columns"),
        (lambda s: s.condition(1.0, [0.0, 0.0], columns=[1, 1]), "columns"),
        (lambda s: s.sample(0, seed=0), "count"),
        (lambda s: s.lasting(0.0), "duration"),
        (lambda s: s.within([0.0] * 3, [0.0] * 3), "lower"),
        (lambda s: s.log_likelihood(lt.Trajectory([0, 1], [[0, 0], [1, 1]])), "trajectory"),
        (lambda s: s.generate(obstacles=[lt.Sphere(0.1, (0, 0, 0))]), "obstacles"),
    ],
)
def test_bad_arguments_are_refused_by_name(skill, call, name):
    with pytest.raises(InvalidInput, match=name):
        call(skill)


@pytest.mark.parametrize(
    "options", [{"weights": 3}, {"basis": "sines"}, {"estimator": "x"}, {"regularization": 0.0}]
)
def test_bad_options_are_refused_by_name(options):
    with pytest.raises(InvalidInput, match=next(iter(options))):
        lt.ProMP(**options)


def test_product_of_gaussians_is_that_of_their_densities():
    rng = np.random.default_rng(3)
    roots = rng.standard_normal((2, 3, 3))
    a, b = (Gaussian(rng.standard_normal(3), root @ root.T) for root in roots)
    both = product([a, b], [1.0, 2.0])
    precision = np.linalg.inv(a.covariance) + 2.0 * np.linalg.inv(b.covariance)
    np.testing.assert_allclose(np.linalg.inv(both.covariance), precision, rtol=1e-6, atol=1e-6)
    pull = np.linalg.solve(a.covariance, a.mean) + 2.0 * np.linalg.solve(b.covariance, b.mean)
    np.testing.assert_allclose(both.mean, np.linalg.solve(precision, pull), atol=1e-8)
