"""Models in the frame of their task."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput
from leadthrough.models import Frame, Framed
from leadthrough.trajectories import minimum_jerk_rise

U = np.linspace(0.0, 1.0, 201)
S = minimum_jerk_rise(U)
POINTS = np.column_stack([0.45 * S, 0.1 * np.sin(np.pi * S), 0.1 * S])
TURNED = rotations.exp(np.outer(S, [0.2, 0.3, 1.0]))
POSES = lt.PoseTrajectory(2.0 * U, POINTS, TURNED, [lt.Event(1.0, "shut")])
MODELS = {
    "poses": (lt.PoseDMP(), POSES),
    "points": (lt.DMP(), lt.Trajectory(2.0 * U, POINTS)),
    "ProMP": (lt.ProMP(), POSES),
}


def turned_by(degrees, origin=(0.0, 0.0, 0.0)):
    axes = rotations.to_matrix(rotations.exp(np.radians([[0.0, 0.0, degrees]])))[0]
    return Frame(origin, axes)


HERE, THERE = turned_by(10.0, (0.4, 0.0, 0.2)), turned_by(130.0, (0.1, 0.5, 0.3))


@pytest.fixture(params=MODELS, ids=str)
def case(request):
    model, seen = MODELS[request.param]
    shown = HERE.base(seen)
    return Framed(model).fit([lt.Demonstration(shown)], frames=[[HERE]]), shown, seen


def test_task_turned_by_120_degrees_is_followed_in_its_frame(case):
    """Asked for its ends in the base frame, a primitive bends by 17 of 46 cm."""
    skill, _, seen = case
    plain, made = skill.generate(), skill.at([THERE]).generate()
    expected = THERE.base(HERE.local(plain))
    np.testing.assert_allclose(made.positions, expected.positions, atol=1e-9)
    rows = np.linspace(0, 200, len(made.times)).round().astype(int)
    np.testing.assert_allclose(made.positions, THERE.base(seen).positions[rows], atol=2e-3)
    if isinstance(made, lt.PoseTrajectory):
        assert rotations.distance(made.orientations, expected.orientations).max() < 1e-7
        assert [event.name for event in made.events] == ["shut"]


def test_query_is_in_the_base_frame(case):
    skill, _, seen = case
    goal = THERE.base(seen).positions[-1] + (0.02, -0.03, 0.01)
    made = skill.at([THERE]).generate(goal=goal, duration=3.0)
    np.testing.assert_allclose(made.positions[-1], goal, atol=1e-8)
    assert made.duration == pytest.approx(3.0)
    if isinstance(made, lt.PoseTrajectory):
        q = rotations.exp([[0.1, 0.2, 2.5]])[0]
        made = skill.at([THERE]).generate(goal=(goal, q))
        assert rotations.distance(made.orientations[-1:], q[None])[0] < 1e-6


def test_obstacles_are_in_the_base_frame():
    skill = Framed(lt.PoseDMP()).fit([lt.Demonstration(HERE.base(POSES))], frames=[[HERE]])
    there = skill.at([THERE])
    above = there.generate().positions[90] + np.array([0.0, 0.0, 0.02])
    box = lt.Box((0.05, 0.04, 0.06), above, (0.8, 0.0, 0.0, 0.6))
    assert box.distance(there.generate().positions).min() < 0.0
    assert box.distance(there.generate(obstacles=[box]).positions).min() > 0.0


def test_framed_skill_is_saved_and_loaded(case, tmp_path):
    skill = case[0].at([THERE])
    skill.save(tmp_path / "skill.npz")
    again = lt.load_skill(tmp_path / "skill.npz")
    assert again.model == skill.model
    for one, other in ((again, skill), (again.at([HERE]), skill.at([HERE]))):
        assert one.generate().positions.tobytes() == other.generate().positions.tobytes()


def test_frame_is_that_of_the_goal_by_default(case):
    skill, shown, _ = case
    made = skill.model.fit([lt.Demonstration(shown)]).generate()
    np.testing.assert_allclose(made.positions, skill.generate().positions, atol=1e-3)


def test_frames_that_do_not_fit_are_refused(case):
    skill, shown, _ = case
    for frames in ([], [HERE, HERE], [None], [Frame((0.0, 0.0))]):
        with pytest.raises(InvalidInput, match="frames"):
            skill.at(frames)
    with pytest.raises(InvalidInput, match="frames"):
        skill.model.fit([lt.Demonstration(shown)], frames=[])
