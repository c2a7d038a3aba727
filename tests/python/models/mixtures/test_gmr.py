"""GMR and task-parameterised GMR: motions, updates, frames, stiffness."""

import numpy as np
import pytest
from refusals import raised, refused
from scipy.interpolate import CubicSpline

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.models import Frame, TaskGMR, stiffness_profile

U = np.linspace(0.0, 1.0, 160)


def test_regression_follows_mean_and_spread_of_the_demonstrations(family):
    shown = family(20)
    skill = lt.GMR(8).fit(shown)
    mean, covariance = skill.regress(2.0 * U)
    curves = np.stack([each.positions for each in shown])
    assert np.abs(mean - curves.mean(axis=0)).max() < 0.03
    spread = np.sqrt(covariance[:, 1, 1])
    assert spread[80] == pytest.approx(curves[:, 80, 1].std(), rel=0.3)
    assert spread[5] < 0.5 * spread[80]


def test_mixture_has_the_time_first_in_seconds(family):
    mixture = lt.GMR(5).fit(family()).mixture
    assert mixture.means.shape == (5, 3)
    assert mixture.covariances.shape == (5, 3, 3)
    assert 1.5 < mixture.means[:, 0].max() < 2.0
    np.testing.assert_allclose(mixture.means[:, 1], mixture.means[:, 0] / 2.0, atol=0.02)


def test_mixture_may_be_asked_for_the_time_of_a_place(family):
    mixture = lt.GMR(8).fit(family()).mixture
    mean, _ = mixture.regress([[0.25], [0.5]], inputs=[1], outputs=[0])
    np.testing.assert_allclose(mean[:, 0], [0.5, 1.0], atol=0.05)


def test_number_of_components_may_be_chosen_by_the_data(family):
    assert lt.GMR().fit(family(2)).mixture.count == 8
    u = np.linspace(0.0, 1.0, 400)
    detailed = np.column_stack([u, 0.2 * np.sin(10.0 * np.pi * u)])
    skill = lt.GMR().fit([lt.Trajectory(2.0 * u, detailed)])
    assert skill.mixture.count > 8
    mean, _ = skill.regress(2.0 * u)
    assert np.linalg.norm(mean - detailed, axis=1).max() < 0.03 * np.linalg.norm([1.0, 0.4])


def long_motion():
    """A motion of 86 s through a random point each second."""
    rng = np.random.default_rng(0)
    points = CubicSpline(np.arange(87.0), rng.normal(0.0, 0.2, (87, 3)))
    times = np.linspace(0.0, 86.0, 4301)
    return lt.Trajectory(times, points(times))


def test_a_long_motion_gets_as_many_components_as_its_detail_needs():
    shown = long_motion()
    skill = lt.GMR().fit([shown])
    assert skill.mixture.count > 64
    # With 64 components of 200 samples it was 0.09.
    for each in (skill, skill.updated([shown])):
        assert lt.models.reproduction(each, [shown]).fraction < 0.05


def test_noise_is_no_detail_that_needs_more_samples(family):
    rng = np.random.default_rng(0)
    u = np.linspace(0.0, 1.0, 2000)
    path = np.column_stack([u, 0.2 * np.sin(np.pi * u)])
    shown = lt.Trajectory(2.0 * u, path + rng.normal(0.0, 0.005, path.shape))
    assert lt.GMR().fit([shown]).mixture.count == 8


def test_update_comes_near_to_a_fit_of_everything(family):
    old, new = family(6, seed=1), family(6, seed=2, height=0.6)
    # One start each: the best of several may be another maximum, which no update leads to.
    model = lt.GMR(6, starts=1)
    both = model.fit(old + new)
    updated = model.fit(old).updated(new)
    assert updated.demonstration_count == 12
    mean, _ = updated.regress(2.0 * U)
    assert np.abs(mean - both.regress(2.0 * U)[0]).max() < 0.05
    before = np.abs(model.fit(old).regress(2.0 * U)[0] - both.regress(2.0 * U)[0]).max()
    assert np.abs(mean - both.regress(2.0 * U)[0]).max() < 0.6 * before


def test_update_with_the_same_changes_nothing(family):
    shown = family(8)
    skill = lt.GMR(5).fit(shown)
    again = skill.updated(shown)
    np.testing.assert_allclose(again.regress(2 * U)[0], skill.regress(2 * U)[0], atol=0.01)


def test_tiny_and_singular_sets_give_usable_models(family):
    one = family(1)
    constant = lt.Trajectory(U, np.column_stack([U, np.full(160, 0.3)]))
    for given in (one, 3 * one, [constant]):
        motion = lt.GMR().fit(given).generate(start=(0.1, 0.1))
        assert np.isfinite(motion.positions).all()
        np.testing.assert_allclose(motion.positions[0], (0.1, 0.1), atol=1e-12)
    assert "none" in str(raised(FitError, lt.GMR().fit, []))


def test_the_order_of_the_demonstrations_does_not_matter(family):
    shown = family(5)
    one, other = (lt.GMR(6).fit(each).mixture for each in (shown, shown[::-1]))
    np.testing.assert_allclose(one.means, other.means, atol=1e-9)


def placed(count, seed):
    """Motions that leave a start along its axes and come into a goal along its own."""
    rng = np.random.default_rng(seed)
    shown, frames = [], []
    for _ in range(count):
        angles = 0.5 * rng.standard_normal(2)
        origins = np.array([[0.0, 0.0], [1.0, 0.5]]) + 0.2 * rng.standard_normal((2, 2))
        axes = [np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in angles]
        start, goal = (Frame(o, a) for o, a in zip(origins, axes, strict=True))
        shown.append(lt.Trajectory(U, bezier(start, goal)))
        frames.append([start, goal])
    return shown, frames


def bezier(start, goal):
    a, d = start.origin, goal.origin
    b, c = a + 0.5 * start.axes[:, 0], d - 0.5 * goal.axes[:, 0]
    u = U[:, None]
    return (1 - u) ** 3 * a + 3 * (1 - u) ** 2 * u * b + 3 * (1 - u) * u**2 * c + u**3 * d


def test_frames_carry_the_motion_to_new_situations():
    shown, frames = placed(20, seed=0)
    framed, plain = TaskGMR(6).fit(shown, frames=frames), lt.GMR(6).fit(shown)
    errors = []
    for new, (start, goal) in zip(*placed(5, seed=7), strict=True):
        query = {"start": start.origin, "goal": goal.origin, "duration": 1.0, "dt": 1.0 / 159}
        motions = framed.at([start, goal]).generate(**query), plain.generate(**query)
        gaps = [np.linalg.norm(m.positions - new.positions, axis=1) for m in motions]
        errors.append([gap.mean() for gap in gaps])
    errors = np.mean(errors, axis=0)
    assert errors[0] < 0.05
    assert errors[0] < 0.75 * errors[1]


def posed(count, seed):
    """Poses that leave a start along its x axis, turn, and come into a goal along its own."""
    rng = np.random.default_rng(seed)
    shown, frames = [], []
    for _ in range(count):
        origins = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.3]]) + 0.15 * rng.standard_normal((2, 3))
        turned = rotations.exp(0.4 * rng.standard_normal((2, 3)) + [[0, 0, 0], [0, 0, 0.8]])
        start, goal = (Frame.of_pose(o, q) for o, q in zip(origins, turned, strict=True))
        share = np.clip((U - 0.35) / 0.3, 0.0, 1.0)
        orientations = rotations.interpolate([0.0, 1.0], turned, share**2 * (3 - 2 * share))
        shown.append(lt.PoseTrajectory(U, bezier(start, goal), orientations))
        frames.append([start, goal])
    return shown, frames


def test_frames_carry_poses_to_new_situations():
    shown, _ = posed(20, seed=0)
    framed, plain = TaskGMR(6).fit(shown), lt.GMR(6).fit(shown)
    errors = []
    for new, (start, goal) in zip(*posed(5, seed=7), strict=True):
        ends = {
            name: (frame.origin, frame.orientations(1)[0])
            for name, frame in (("start", start), ("goal", goal))
        }
        made = [s.generate(**ends, duration=1.0, dt=1.0 / 159) for s in (framed, plain)]
        away = [np.linalg.norm(m.positions - new.positions, axis=1).mean() for m in made]
        turned = [rotations.distance(m.orientations, new.orientations).mean() for m in made]
        errors.append([away, turned])
    framed, plain = np.mean(errors, axis=0).T
    assert (framed < [0.065, 0.05]).all()  # m, rad
    assert (framed < 0.6 * plain).all()


def test_a_task_that_is_moved_as_a_whole_moves_the_motion_and_its_spread():
    shown, frames = posed(8, seed=1)
    skill = TaskGMR(4).fit(shown, frames=frames)
    turn = rotations.exp([[0.3, -1.2, 2.0]])
    matrix, shift = rotations.to_matrix(turn)[0], np.array([1.0, -2.0, 0.5])
    moved = [Frame(matrix @ frame.origin + shift, matrix @ frame.axes) for frame in frames[0]]
    here, there = skill.at(frames[0]), skill.at(moved)
    a, b = here.generate(), there.generate()
    np.testing.assert_allclose(b.positions, a.positions @ matrix.T + shift, atol=1e-8)
    expected = rotations.compose(np.repeat(turn, len(a.times), axis=0), a.orientations)
    assert rotations.distance(b.orientations, expected).max() < 1e-7
    spread = [each.regress(U * each.duration)[1] for each in (here, there)]
    np.testing.assert_allclose(spread[1][:, :3, :3], matrix @ spread[0][:, :3, :3] @ matrix.T)
    # A rotation vector in the tool's own frame does not see that the base has moved.
    np.testing.assert_allclose(spread[1][:, 3:, 3:], spread[0][:, 3:, 3:], atol=1e-9)


def test_a_frame_that_moves_joints_shifts_them():
    joints = [
        lt.JointTrajectory(U, np.column_stack([U, a * np.sin(3 * U)]), joint_names=("a", "b"))
        for a in (0.9, 1.0, 1.1)
    ]
    frame = Frame((0.0, 0.0))
    skill = TaskGMR(4).fit(joints, frames=3 * [[frame]])
    plain, moved = (skill.at([f]).generate() for f in (frame, Frame((0.5, -0.2))))
    assert moved.joint_names == ("a", "b")
    np.testing.assert_allclose(moved.positions, plain.positions + np.array([0.5, -0.2]), atol=1e-9)
    with pytest.raises(InvalidInput, match="right-handed"):
        shown, _ = posed(2, seed=0)
        TaskGMR(2).fit(shown, frames=2 * [[Frame((0, 0, 0), np.diag([1.0, 1.0, -1.0]))]])


def test_skill_with_frames_of_its_own_says_how_to_ask_it(tmp_path):
    shown, frames = placed(4, seed=0)
    skill = TaskGMR(3).fit(shown, frames=frames)
    assert "at" in str(raised(UnsupportedQuery, skill.generate, start=(0.0, 0.0)))
    refused("frames", skill.at, frames[0][:1])
    refused("axes", Frame, (0.0, 0.0), 2.0 * np.eye(2))
    skill.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz").at(frames[0])
    assert (
        loaded.generate().positions.tobytes() == skill.at(frames[0]).generate().positions.tobytes()
    )


def test_stiffness_is_high_where_and_along_what_demonstrations_agree(family):
    _, covariance = lt.GMR(8).fit(family(20)).regress(2.0 * U)
    stiffness = stiffness_profile(covariance, softest=50.0, stiffest=800.0)
    values = np.linalg.eigvalsh(stiffness)
    assert values.min() == pytest.approx(50.0)
    assert values.max() == pytest.approx(800.0)
    assert stiffness[80, 1, 1] < 0.2 * stiffness[3, 1, 1]
    np.testing.assert_allclose(stiffness, stiffness.transpose(0, 2, 1), atol=1e-9)
    # The least stiff axis is the one that varies the most.
    most = np.linalg.eigh(covariance)[1][:, :, -1]
    least = np.linalg.eigh(stiffness)[1][:, :, 0]
    np.testing.assert_allclose(np.abs(np.einsum("ni,ni->n", most, least)), 1.0, atol=1e-6)


def test_stiffness_of_an_even_spread_is_the_stiffest_and_bad_input_is_refused():
    even = np.tile(np.eye(2), (4, 1, 1))
    np.testing.assert_allclose(
        stiffness_profile(even, softest=1.0, stiffest=9.0), 9.0 * even, atol=1e-9
    )
    for covariances in (-even, 0.0 * even, even + np.eye(2, k=1)):
        refused("covariances", stiffness_profile, covariances, softest=1.0, stiffest=9.0)
    refused("stiffest", stiffness_profile, even, softest=2.0, stiffest=1.0)
