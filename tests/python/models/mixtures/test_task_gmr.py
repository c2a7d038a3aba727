"""Task-parameterised GMR: motions carried by frames to new situations."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models import Frame, TaskGMR

U = np.linspace(0.0, 1.0, 160)


def placed(count, seed):
    """Motions that leave a start along its axes and come into a goal along its own."""
    rng = np.random.default_rng(seed)
    shown, frames = [], []
    for _ in range(count):
        angles = 0.5 * rng.standard_normal(2)
        origins = np.array([[0.0, 0.0], [1.0, 0.5]]) + 0.2 * rng.standard_normal((2, 2))
        axes = [np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in angles]
        start, goal = (Frame(o, a) for o, a in zip(origins, axes, strict=True))
        shown.append(lt.Demonstration(lt.Trajectory(U, bezier(start, goal))))
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
        gaps = [np.linalg.norm(m.positions - new.motion.positions, axis=1) for m in motions]
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
        motion = lt.PoseTrajectory(U, bezier(start, goal), rotations.align_signs(orientations))
        shown.append(lt.Demonstration(motion))
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
        errors.append(
            [
                [
                    np.linalg.norm(m.positions - new.motion.positions, axis=1).mean(),
                    rotations.distance(m.orientations, new.motion.orientations).mean(),
                ]
                for m in made
            ]
        )
    framed, plain = np.mean(errors, axis=0)
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
    skill = TaskGMR(4).fit([lt.Demonstration(each) for each in joints], frames=3 * [[frame]])
    plain, moved = (skill.at([f]).generate() for f in (frame, Frame((0.5, -0.2))))
    assert moved.joint_names == ("a", "b")
    np.testing.assert_allclose(moved.positions, plain.positions + np.array([0.5, -0.2]), atol=1e-9)
    with pytest.raises(InvalidInput, match="right-handed"):
        shown, _ = posed(2, seed=0)
        TaskGMR(2).fit(shown, frames=2 * [[Frame((0, 0, 0), np.diag([1.0, 1.0, -1.0]))]])


def test_skill_with_frames_of_its_own_says_how_to_ask_it(tmp_path):
    shown, frames = placed(4, seed=0)
    skill = TaskGMR(3).fit(shown, frames=frames)
    with pytest.raises(UnsupportedQuery, match="at"):
        skill.generate(start=(0.0, 0.0))
    with pytest.raises(InvalidInput, match="frames"):
        skill.at(frames[0][:1])
    with pytest.raises(InvalidInput, match="axes"):
        Frame((0.0, 0.0), 2.0 * np.eye(2))
    skill.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz").at(frames[0])
    assert (
        loaded.generate().positions.tobytes() == skill.at(frames[0]).generate().positions.tobytes()
    )
