"""ProMPs fitted to demonstrations: distribution, samples, likelihood, files, moved ends."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import raised, refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.io import lasa

TIMES = np.linspace(0.0, 2.0, 200)


def test_mean_and_spread_are_those_of_the_demonstrations(shown):
    demonstrations = shown(40)
    mean, covariance = lt.ProMP().fit(demonstrations).distribution(TIMES)
    curves = np.stack([each.positions for each in demonstrations])
    np.testing.assert_allclose(mean, curves.mean(axis=0), atol=1e-3)
    deviation = np.sqrt(np.einsum("nii->ni", covariance))
    np.testing.assert_allclose(deviation, curves.std(axis=0, ddof=1), atol=0.05)


def test_the_number_of_weights_follows_a_long_motion_and_is_saved(tmp_path):
    t = np.linspace(0.0, 86.0, 1500)
    path = np.column_stack([0.01 * t, 0.2 * np.sin(1.5 * t), 0.1 * np.cos(1.1 * t)])
    skill = lt.ProMP().fit([lt.Trajectory(t, path)])
    assert np.abs(skill.distribution(t[::50])[0] - path[::50]).max() < 0.01
    assert skill.model.weights == skill.basis.count > 20
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").model == skill.model
    assert lt.ProMP().fit([lt.Trajectory(t[:90], path[:90])]).model.weights == 20


@pytest.mark.parametrize("estimator", ["least_squares", "em"])
def test_tiny_and_singular_sets_give_usable_models(estimator, shown):
    demonstrations = shown(1)
    still = np.array(demonstrations[0].positions)
    still[:, 1] = 0.4
    constant = [lt.JointTrajectory(TIMES, still + 0.01 * i) for i in range(2)]
    for several in (demonstrations, 3 * demonstrations, constant):
        skill = lt.ProMP(estimator=estimator).fit(several)
        via = skill.distribution([1.0])[0][0] + 0.05
        motion = skill.condition(1.0, via).generate(start=(0.1, 0.4, 0.1))
        np.testing.assert_allclose(motion.positions[0], (0.1, 0.4, 0.1), atol=1e-6)
        np.testing.assert_allclose(motion.positions[100], via, atol=1e-6)
        assert np.isfinite(skill.log_likelihood(several[0]))
        assert len(skill.sample(2, seed=0)) == 2


def test_few_samples_are_enough():
    u = np.linspace(0.0, 1.0, 4)
    few = [lt.Trajectory(u, np.column_stack([u, a * u])) for a in (0.9, 1.1)]
    mean, _ = lt.ProMP().fit(few).distribution(np.linspace(0, 1, 30))
    np.testing.assert_allclose(mean[:, 1], mean[:, 0], atol=0.02)


def test_demonstrations_and_options_that_do_not_fit_are_refused(shown):
    demonstrations = shown(2)
    with pytest.raises(FitError, match="em"):
        lt.ProMP().fit(demonstrations, phases=[np.linspace(0, 1, 200), np.linspace(0.5, 1, 200)])
    for ends in [(-0.1, 1.0), (0.0, 1.1)]:
        with pytest.raises(InvalidInput, match=r"phases\[1\]: expected phases in \[0, 1\]"):
            lt.ProMP().fit(shown(2), phases=[np.linspace(0, 1, 200), np.linspace(*ends, 200)])
    for options in [
        {"weights": 3},
        {"basis": "sines"},
        {"estimator": "x"},
        {"regularization": 0.0},
    ]:
        refused(next(iter(options)), lt.ProMP, **options)


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


def test_samples_are_repeatable_and_of_the_type_shown(skill, shown):
    first, second = (skill.sample(3, seed=7) for _ in range(2))
    assert len(first) == 3
    for a, b in zip(first, second, strict=True):
        assert isinstance(a, lt.JointTrajectory)
        assert a.positions.tobytes() == b.positions.tobytes()
    assert skill.sample(1, seed=8)[0].positions.tobytes() != first[0].positions.tobytes()


def test_likelihood_tells_alike_from_strange_and_ignores_duration(shown):
    skill = lt.ProMP().fit(shown(noise=0.01))
    alike = shown(1, seed=5, noise=0.01)[0]
    slow = shown(1, seed=5, noise=0.01, duration=6.0)[0]
    strange = lt.JointTrajectory(alike.times, alike.positions[::-1])
    assert skill.log_likelihood(alike) > skill.log_likelihood(strange)
    assert skill.log_likelihood(slow) == pytest.approx(skill.log_likelihood(alike))


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
        lt.Trajectory(3 * u, r * np.column_stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)]))
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
    assert "goal" in str(raised(UnsupportedQuery, skill.generate, goal=(1.0, 0.0)))


def test_skill_with_limits_and_joints_is_saved(skill, tmp_path):
    limited = skill.within([-9.0] * 3, [1.0, np.inf, 9.0])
    limited.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert loaded.coordinates.joint_names == ("a", "b", "c")
    assert loaded.generate().positions.tobytes() == limited.generate().positions.tobytes()
    for a, b in zip(loaded.bounds, limited.bounds, strict=True):
        np.testing.assert_array_equal(a, b)


def test_bad_arguments_are_refused_by_name(skill):
    huge = replace(skill.free, mean=1e307 * skill.free.mean)
    with pytest.raises(InvalidInput, match="velocities: expected finite"):
        skill.with_weights(huge).lasting(1e-6).sample(2, seed=0, dt=1e-7)
    for call, name in [
        (lambda s: s.distribution([0.1, 2.5]), "times: .* got 2.5 s"),
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
        (lambda s: s.log_likelihood(3), "trajectory: .* got int"),
        (lambda s: s.log_likelihood(lt.Trajectory([0], [[0]])), "trajectory: .* got one sample"),
        (lambda s: s.generate(obstacles=[lt.Sphere(0.1, (0, 0, 0))]), "obstacles"),
    ]:
        refused(name, call, skill)


U = np.linspace(0.0, 1.0, 100)
# Largest deviation of a motion, in multiples of its ends' displacement.
BOUND = 1.5
JOINTS = tuple(f"joint{i}" for i in range(1, 8))


def moved_by(motion, other):
    return float(np.linalg.norm(motion.positions - other.positions, axis=1).max())


def size_of(motion):
    return float(np.linalg.norm(np.ptp(motion.positions, axis=0)))


def joints_from_one_posture(count, seed=0):
    """Motions of seven joints that all start in the same posture."""
    rng = np.random.default_rng(seed)
    ready = np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])
    shown = []
    for _ in range(count):
        reach = rng.normal(0.5, 0.1, 7)
        wiggle = rng.normal(0.0, 0.1, 7)
        path = ready + np.outer(U**2, reach) + np.outer(np.sin(np.pi * U) ** 2, wiggle)
        shown.append(lt.JointTrajectory(2.0 * U, path, joint_names=JOINTS))
    return shown


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_moved_ends_of_handwriting_never_throw_the_motion(count):
    for name in lasa.motions()[::3]:
        skill = lt.ProMP().fit(lasa.load(name)[:count])
        before = skill.generate(dt=0.05)
        for fraction in (0.05, 0.1, 0.5):
            for angle in (0.3, 1.9, 3.4, 5.0):
                offset = np.array([np.cos(angle), np.sin(angle)]) * fraction * size_of(before)
                start, goal = before.positions[0] + offset, before.positions[-1] - offset
                for asked in ({"start": start}, {"goal": goal}, {"start": start, "goal": goal}):
                    made = skill.generate(**asked, dt=0.05)
                    assert moved_by(made, before) <= BOUND * np.linalg.norm(offset), (name, asked)
                    if "start" in asked:
                        np.testing.assert_allclose(made.positions[0], start, atol=1e-9)
                    if "goal" in asked:
                        np.testing.assert_allclose(made.positions[-1], goal, atol=1e-9)


@pytest.mark.parametrize("count", [2, 5, 40])
@pytest.mark.parametrize("offset", [0.01, 0.3, 3.0])
def test_an_arm_shown_from_one_posture_starts_beside_it(count, offset):
    skill = lt.ProMP().fit(joints_from_one_posture(count))
    before = skill.generate()
    start = before.positions[0] + offset / np.sqrt(7.0)
    assert moved_by(skill.generate(start=start), before) <= BOUND * offset


def test_a_plane_drawing_is_raised_as_a_whole(recordings):
    shown = lt.read_demonstrations(
        [recordings / "panda_symbol" / "symbol17.mat"], rate=1000.0, columns={"positions": ["pos"]}
    )
    skill = lt.ProMP().fit(shown)
    before = skill.generate()
    goal = before.positions[-1] + [0.0, 0.0, 0.02]
    assert moved_by(skill.generate(goal=goal), before) <= BOUND * 0.02


def test_a_moved_position_does_not_turn_a_pose_beyond_a_moved_orientation():
    rng = np.random.default_rng(2)
    shown = []
    for _ in range(4):
        positions = np.column_stack([U, rng.normal() * 0.1 * U, np.sin(U)])
        turned = rotations.exp(np.outer(U, [1.0, 0.2 * rng.normal(), 0.0]))
        shown.append(lt.PoseTrajectory(3.0 * U, positions, turned))
    skill = lt.ProMP().fit(shown)
    before = skill.generate()
    turn = rotations.exp(np.array([[0.0, 0.0, 0.1]]))
    goal = before.positions[-1] + 0.2, rotations.compose(turn, before.orientations[-1:])[0]
    made = skill.generate(goal=goal)
    assert moved_by(made, before) <= BOUND * 0.2 * np.sqrt(3.0)
    assert rotations.distance(made.orientations, before.orientations).max() <= BOUND * 0.1
    assert rotations.distance(made.orientations[-1:], goal[1][None])[0] < 1e-6


def test_inside_what_was_shown_the_ends_tell_the_way():
    # Whoever starts higher passes higher, and comes down late; a shift alone fades evenly.
    heights = np.linspace(-1.0, 1.0, 40)
    shown = [lt.Trajectory(U, np.column_stack([U, y * (1.0 - U**3)])) for y in heights]
    made = lt.ProMP().fit(shown).generate(start=(0.0, 0.8), dt=0.01)
    np.testing.assert_allclose(made.positions[:, 1], 0.8 * (1.0 - made.times**3), atol=0.05)


def test_a_moved_start_fades_along_the_path_not_with_the_time():
    path = np.column_stack([np.interp(U, [0.0, 0.6, 1.0], [0.0, 0.1, 1.0]), 0.0 * U])
    made = lt.ProMP().fit([lt.Trajectory(2.0 * U, path)]).generate(start=(0.0, 0.1), dt=0.01)
    np.testing.assert_allclose(made.positions[:, 1], 0.1 * (1.0 - made.positions[:, 0]), atol=0.01)


def test_a_pose_turns_as_poses_that_began_there_did():
    shown = []
    for y in np.linspace(-1.0, 1.0, 20):
        fading = y * (1.0 - U**3)
        points = np.column_stack([0.1 * U, fading, 0.0 * U])
        turned = rotations.exp(np.outer(0.5 * fading, [1.0, 0.0, 0.0]))
        shown.append(lt.PoseTrajectory(U, points, turned))
    made = lt.ProMP().fit(shown).generate(start=(0.0, 0.8, 0.0), dt=0.01)
    expected = rotations.exp(np.outer(0.4 * (1.0 - made.times**3), [1.0, 0.0, 0.0]))
    np.testing.assert_allclose(made.positions[:, 1], 0.8 * (1.0 - made.times**3), atol=0.05)
    assert rotations.distance(made.orientations, expected).max() < 0.05


def test_novelty_counts_standard_deviations_of_the_ends():
    starts = np.array([-1.0, 0.0, 1.0])  # standard deviation 1
    shown = [lt.Trajectory(U, np.column_stack([U, y * (1.0 - U)])) for y in starts]
    skill = lt.ProMP().fit(shown)
    assert skill.novelty() == 0.0
    assert skill.novelty(start=skill.generate().positions[0]) == pytest.approx(0.0, abs=1e-6)
    assert skill.novelty(start=(0.0, 2.0)) == pytest.approx(2.0, rel=0.05)
    assert skill.novelty(start=(0.0, 6.0)) == pytest.approx(6.0, rel=0.05)
    assert skill.novelty(goal=(1.0, 0.5)) > 3.0  # all demonstrations agree at the end
    assert skill.condition(0.0, (0.0, 1.0)).novelty(start=(0.0, 0.0)) == np.inf


def test_via_points_stay_where_start_and_goal_move():
    skill = lt.ProMP().fit(joints_from_one_posture(4)).condition(1.0, np.full(7, 0.2))
    made = skill.generate(start=np.full(7, 0.1), goal=np.full(7, 0.4))
    np.testing.assert_allclose(made.positions[100], 0.2, atol=1e-6)
    np.testing.assert_allclose(made.positions[[0, -1]], [[0.1] * 7, [0.4] * 7], atol=1e-6)


PHASES = np.linspace(0.0, 1.0, 301)


def in_the_peers_layout(count):
    """movement_primitives' functions: all centres inside, their overlap 0.7."""
    centres = np.linspace(0.0, 1.0, count)
    variance = -1.0 / (8.0 * count**2 * np.log(0.7))
    rows = np.exp(-((PHASES[:, None] - centres) ** 2) / (2.0 * variance))
    return rows / rows.sum(axis=1, keepdims=True)


def detailed(length, seed=0):
    """Twenty motions of seven joints with detail of a length, varying about a common one."""
    rng = np.random.default_rng(seed)
    gaps = (PHASES[:, None] - PHASES) / length
    root = np.linalg.cholesky(np.exp(-0.5 * gaps**2) + 1e-9 * np.eye(len(PHASES)))
    drawn = np.einsum("ij,mjk->mik", root, rng.normal(size=(20, len(PHASES), 7)))
    return (root @ rng.normal(size=(len(PHASES), 7))) + 0.2 * drawn


def distributed(curves, count):
    """Means and standard deviations: of a skill, and of least squares in the peer's layout."""
    skill = lt.ProMP(weights=count).fit([lt.JointTrajectory(PHASES, each) for each in curves])
    mean, covariance = skill.distribution(PHASES)
    rows = in_the_peers_layout(count)
    theirs = rows @ np.linalg.pinv(rows) @ curves
    # The peer's estimate is the most likely one, which divides by the number of motions.
    return (mean, np.sqrt(np.einsum("nii->ni", covariance))), (theirs.mean(0), theirs.std(0))


def rms(errors):
    return float(np.sqrt((errors**2).mean()))


@pytest.mark.parametrize("count", [6, 10, 14])
@pytest.mark.parametrize("length", [0.3, 0.15, 0.1])
def test_as_few_functions_resolve_as_much_as_the_peers(length, count):
    curves = detailed(length)
    (ours, _), (theirs, _) = distributed(curves, count)
    assert rms(ours - curves.mean(axis=0)) <= rms(theirs - curves.mean(axis=0))


@pytest.mark.parametrize("count", [6, 10, 14])
@pytest.mark.parametrize("length", [0.3, 0.15, 0.1, 0.07, 0.05])
def test_deviations_are_told_as_finely_as_by_the_peer(length, count):
    curves = detailed(length)
    (_, ours), (_, theirs) = distributed(curves, count)
    shown = curves.std(axis=0, ddof=1)
    assert rms(ours - shown) <= rms(theirs - shown)


@pytest.mark.parametrize(
    ("length", "count", "middle"), [(0.07, 6, 14), (0.07, 10, 17), (0.05, 10, 13), (0.05, 14, 9)]
)
def test_detail_finer_than_the_functions_is_told_nearly_as_well_as_by_any_functions(
    length, count, middle
):
    """The least error of any `count` functions is that of the motions' principal components."""
    gaps = (PHASES[:, None] - PHASES) / length
    beyond = np.linalg.eigvalsh(np.exp(-0.5 * gaps**2))[:-count]
    least = np.sqrt(beyond.clip(0.0).sum() / len(PHASES))
    assert least > 0.18  # of detail whose height is 1
    excesses = []
    for seed in range(20):
        curves = detailed(length, seed)
        excesses.append(100.0 * rms(distributed(curves, count)[0][0] - curves.mean(axis=0)) / least)
    assert np.median(excesses) - 100.0 == pytest.approx(middle, abs=0.5)  # percent, as documented
    assert max(excesses) < 142.5
