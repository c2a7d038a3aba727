"""Models in the frame of their task."""

from dataclasses import replace

import numpy as np
import pytest
from kinds import kind
from refusals import raised, refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import UnsupportedQuery
from leadthrough.models import Frame, Framed
from leadthrough.trajectories import minimum_jerk_time_scaling

U = np.linspace(0.0, 1.0, 201)
S = minimum_jerk_time_scaling(U)
POINTS = np.column_stack([0.45 * S, 0.1 * np.sin(np.pi * S), 0.1 * S])
TURNED = rotations.exp(np.outer(S, [0.2, 0.3, 1.0]))
POSES = lt.PoseTrajectory(2.0 * U, POINTS, TURNED, [lt.Event(1.0, "shut")])
MOTIONS = {"poses": POSES, "points": lt.Trajectory(2.0 * U, POINTS)}
LEARNERS = (kind("DMP", "poses"), kind("DMP"), kind("ProMP", "poses"))


def pose_primitive(**settings):
    return kind("DMP", "poses", **settings).build()


def turned_by(degrees, origin=(0.0, 0.0, 0.0)):
    axes = rotations.to_matrix(rotations.exp(np.radians([[0.0, 0.0, degrees]])))[0]
    return Frame(origin, axes)


HERE, THERE = turned_by(10.0, (0.4, 0.0, 0.2)), turned_by(130.0, (0.1, 0.5, 0.3))


@pytest.fixture(params=LEARNERS, ids=str)
def case(request):
    model, seen = request.param.build(), MOTIONS[request.param.motion]
    shown = HERE.base(seen)
    return Framed(model).fit([shown], frames=[[HERE]]), shown, seen


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
    skill = Framed(pose_primitive()).fit([HERE.base(POSES)], frames=[[HERE]])
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
    made = skill.model.fit([shown]).generate()
    np.testing.assert_allclose(made.positions, skill.generate().positions, atol=1e-3)


def test_via_points_and_velocities_are_in_the_base_frame():
    for motion, seen in MOTIONS.items():
        model = kind("DMP", motion).build()
        skill = Framed(model).fit([HERE.base(seen)], frames=[[HERE]]).at([THERE])
        assert {"via", "start_velocity", "final_velocity"} <= skill.supports
        plain = skill.generate(duration=2.0, dt=1e-3)
        through, rate = plain.positions[1000] + (0.03, 0.02, -0.01), np.array([0.1, -0.05, 0.02])
        made = skill.generate(
            duration=2.0, dt=1e-3, via=[(0.5, through)], start_velocity=rate, final_velocity=-rate
        )
        np.testing.assert_allclose(made.positions[1000], through, atol=1e-6)
        np.testing.assert_allclose((made.positions[1] - made.positions[0]) / 1e-3, rate, atol=5e-3)
        np.testing.assert_allclose(
            (made.positions[-1] - made.positions[-2]) / 1e-3, -rate, atol=5e-3
        )


@pytest.mark.parametrize("motion", MOTIONS)
def test_steps_in_a_frame_are_those_of_the_whole_motion(motion):
    model, seen = kind("DMP", motion).build(), MOTIONS[motion]
    skill = Framed(model).fit([HERE.base(seen)], frames=[[HERE]]).at([THERE])
    whole, state = skill.generate(dt=0.05), skill.begin()
    np.testing.assert_allclose(state.position, whole.positions[0], atol=1e-9)
    step = whole.times[1]
    for row in range(1, len(whole.times)):
        state = skill.step(state, step)
        np.testing.assert_allclose(state.position, whole.positions[row], atol=1e-8)
        if motion == "poses":
            turned = rotations.distance(state.orientation[None], whole.orientations[[row]])
            assert turned[0] < 1e-6
    assert state.phase == pytest.approx(1.0)
    assert state.duration == pytest.approx(whole.duration)


def test_goal_push_and_measurement_of_a_step_are_in_the_base_frame():
    model, seen = pose_primitive(), POSES
    skill = Framed(model).fit([HERE.base(seen)], frames=[[HERE]]).at([THERE])
    goal = THERE.base(seen).positions[-1] + (0.02, -0.03, 0.01)
    state = skill.begin()
    while state.phase < 1.0:
        state = skill.step(state, 0.01, goal=goal if state.phase >= 0.3 else None)
    np.testing.assert_allclose(state.position, goal, atol=1e-3)
    begun = skill.begin()
    push = np.array([1.0, 2.0, -1.0, 0.5, 0.0, 1.0])
    free, pushed = skill.step(begun, 0.01), skill.step(begun, 0.01, coupling=push)
    np.testing.assert_allclose((pushed.velocity - free.velocity) / 0.01, push[:3], rtol=0.1)
    turn = (pushed.angular_velocity - free.angular_velocity) / 0.01
    np.testing.assert_allclose(turn, push[3:], atol=0.2)
    there = begun.position + np.array([0.01, 0.0, 0.02])
    moved = skill.step(begun, 1e-6, measured=there)
    np.testing.assert_allclose(moved.position, there, atol=1e-6)


def test_a_policy_is_asked_and_answers_in_the_base_frame():
    shown = lt.Trajectory(2.0 * U, POINTS[:, :2])
    turn = rotations.to_matrix(rotations.exp(np.radians([[0.0, 0.0, 120.0]])))[0][:2, :2]
    here, there = Frame((0.0, 0.0)), Frame((0.3, 0.1), turn)
    skill = Framed(lt.FastMarching()).fit([shown], frames=[[here]])
    place = np.array([0.2, 0.12])
    expected = turn @ skill.policy(place)
    found = skill.at([there]).policy(turn @ place + (0.3, 0.1))
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert np.linalg.norm(found) > 0.01


@pytest.mark.parametrize(
    ("name", "motion"), [("CLFDM", "poses"), ("LPVDS", "points"), ("FastMarching", "points")]
)
def test_policies_in_a_frame_step_to_where_they_lead_in_the_task(name, motion):
    settings = {} if name == "FastMarching" else {"components": 2}
    seen = MOTIONS[motion]
    framed = Framed(kind(name, motion, **settings).build())
    skill = framed.fit([HERE.base(seen)], frames=[[HERE]]).at([THERE])
    rows = [40, 120]
    shown = THERE.base(seen)
    here = shown.positions[rows]
    if motion == "poses":
        here, seen_rows = (here, shown.orientations[rows]), (seen.positions[rows], TURNED[rows])
        after, inside = skill.step(here, 0.02), skill.skill.step(seen_rows, 0.02)
        np.testing.assert_allclose(after[0], THERE.base(lt.Trajectory([0, 1], inside[0])).positions)
        expected = rotations.compose(THERE.orientations(2), inside[1])
        assert rotations.distance(after[1], expected).max() < 1e-7
        one = skill.step((here[0][1], here[1][1]), 0.02)
        np.testing.assert_allclose(one[0], after[0][1], atol=1e-9)
        velocity = skill.policy(here)
        later = skill.step(here, 1e-5)
        np.testing.assert_allclose(velocity[:, :3], (later[0] - here[0]) / 1e-5, atol=1e-4)
        turned = rotations.log(rotations.compose(later[1], rotations.inverse(here[1]))) / 1e-5
        np.testing.assert_allclose(velocity[:, 3:], turned, atol=1e-3)
        goal = (shown.positions[-1] + (0.02, 0.0, 0.0), shown.orientations[-1])
        assert np.abs(skill.step(here, 0.02, goal=goal)[0] - after[0]).max() > 1e-5
    else:
        after = skill.step(here, 0.02)
        inside = lt.Trajectory([0, 1], skill.skill.step(seen.positions[rows], 0.02))
        np.testing.assert_allclose(after, THERE.base(inside).positions, atol=1e-9)
        np.testing.assert_allclose(skill.step(here[1], 0.02), after[1], atol=1e-9)
    with pytest.raises(UnsupportedQuery, match="coupling: step of a skill of kind"):
        skill.step(here, 0.02, coupling=np.zeros(3))


def test_a_via_point_of_a_distribution_is_in_the_base_frame():
    rng = np.random.default_rng(2)
    for motion, first in MOTIONS.items():
        seen = [first]
        seen += [
            replace(seen[0], positions=seen[0].positions + rng.normal(0.0, 0.02, 3))
            for _ in range(4)
        ]
        shown = [HERE.base(each) for each in seen]
        skill = Framed(lt.ProMP()).fit(shown, frames=[[HERE]] * 5).at([THERE])
        plain = skill.generate(dt=0.01)
        row = len(plain.times) // 2
        through = plain.positions[row] + (0.01, 0.015, -0.01)
        place = (through, plain.orientations[row]) if motion == "poses" else through
        made = skill.condition(plain.times[row], place).generate(dt=0.01)
        np.testing.assert_allclose(made.positions[row], through, atol=1e-6)
        if motion == "points":
            # Sure of the height only: across it, the motion is pulled nowhere.
            loose = skill.condition(
                plain.times[row], through, covariance=np.diag([1e6, 1e6, 1e-12])
            )
            height = loose.generate(dt=0.01).positions[row, 2]
            assert height == pytest.approx(through[2], abs=1e-6)
        else:
            with pytest.raises(UnsupportedQuery, match="covariance"):
                skill.condition(plain.times[row], place, covariance=np.eye(6))
    primitive = Framed(lt.DMP()).fit(shown, frames=[[HERE]] * 5)
    with pytest.raises(UnsupportedQuery, match=r"condition.*Framed\(ProMP\(\)\)"):
        primitive.condition(1.0, (0.0, 0.0, 0.0))


def test_limits_are_in_the_base_frame_where_its_axes_are_those_of_the_task():
    seen = MOTIONS["points"]
    quarter = turned_by(90.0, (0.4, 0.0, 0.2))
    skill = Framed(lt.DMP()).fit([quarter.base(seen)], frames=[[quarter]])
    assert "limits" in skill.supports
    for frame in (quarter, turned_by(0.0, (0.1, 0.5, 0.3)), turned_by(180.0)):
        there = skill.at([frame])
        free = there.generate()
        low, high = np.sort(free.positions[[0, -1]], axis=0) + np.array([[-0.05], [0.05]])
        assert ((free.positions < low) | (free.positions > high)).any()
        made = there.generate(limits=(low, high))
        assert (made.positions >= low - 1e-9).all() and (made.positions <= high + 1e-9).all()
        state = there.begin()
        while state.phase < 1.0:
            state = there.step(state, 0.01, limits=(low, high))
            assert ((state.position >= low - 1e-9) & (state.position <= high + 1e-9)).all()
    with pytest.raises(UnsupportedQuery, match=r"limits: .*obstacles"):
        skill.at([THERE]).generate(limits=(-np.ones(3), np.ones(3)))
    for wrong in ((1.0,), (np.ones(3), -np.ones(3))):
        refused("limits", skill.generate, limits=wrong)
    poses = Framed(pose_primitive()).fit([HERE.base(POSES)], frames=[[HERE]])
    with pytest.raises(UnsupportedQuery, match=r"limits: .*Framed\(DMP\(\)\)"):
        poses.generate(limits=(-np.ones(3), np.ones(3)))


def test_what_the_skill_inside_does_not_take_is_refused_by_name(case):
    skill, shown, _ = case
    for frames in ([], [HERE, HERE], [None], [Frame((0.0, 0.0))]):
        refused("frames", skill.at, frames)
    refused("frames", skill.model.fit, [shown], frames=[])
    shown = HERE.base(POSES)
    promp = Framed(lt.ProMP()).fit([shown], frames=[[HERE]])
    for name, value in (
        ("via", [(0.5, (0.0, 0.0, 0.0))]),
        ("start_velocity", (0.1, 0.0, 0.0)),
        ("final_velocity", (0.1, 0.0, 0.0)),
    ):
        with pytest.raises(UnsupportedQuery, match=f"{name}: a skill of kind 'promp'"):
            promp.generate(**{name: value})
    for ask in (promp.begin, lambda: promp.policy((0.0, 0.0, 0.0))):
        assert "Framed" in str(raised(UnsupportedQuery, ask))
    hoffmann = Framed(pose_primitive(form="hoffmann")).fit([shown], frames=[[HERE]])
    with pytest.raises(UnsupportedQuery, match="final_velocity"):
        hoffmann.generate(final_velocity=(0.1, 0.0, 0.0))
    skill = Framed(pose_primitive()).fit([shown], frames=[[HERE]])
    for query in ({"via": [(0.5, (0.0, 0.0))]}, {"via": [0.5]}, {"start_velocity": (0.1,)}):
        refused(next(iter(query)), skill.generate, **query)
    refused("coupling", skill.step, skill.begin(), 0.01, coupling=(1.0,))
