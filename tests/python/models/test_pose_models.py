"""Models of poses: orientations in tangent spaces of a reference, and their mean."""

from dataclasses import replace

import numpy as np
import pytest
from kinds import kind

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.models import TaskGMR
from leadthrough_studies.comparison.recordings import read

U = np.linspace(0.0, 1.0, 120)


def turning(count=6, *, angle=5.0, seed=0):
    """Poses that turn by an angle, rad, about an axis that varies a little."""
    rng = np.random.default_rng(seed)
    shown = []
    for _ in range(count):
        axis = np.array([0.1, 0.2, 1.0]) + 0.05 * rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        quaternions = rotations.exp(np.outer(angle * U, axis))
        points = np.column_stack([U, np.sin(U), 0.1 * rng.standard_normal() * U])
        shown.append(lt.PoseTrajectory(3.0 * U, points, quaternions))
    return shown


@pytest.fixture(scope="module", params=[lt.ProMP(), lt.GMR(10)], ids=["ProMP", "GMR"])
def skill(request):
    return request.param.fit(turning())


def test_position_alone_may_be_given(skill):
    motion = skill.generate(start=(0.1, 0.0, 0.1))
    np.testing.assert_allclose(motion.positions[0], (0.1, 0.0, 0.1), atol=1e-8)
    with pytest.raises(InvalidInput, match=r"goal: expected .*\(position \(3,\), orientation"):
        skill.generate(goal=(0.1, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0))


def test_frame_of_the_demonstrations_does_not_matter():
    turn = rotations.exp([[0.5, -1.0, 2.0]])
    shown = turning()
    turns = np.repeat(turn, len(U), axis=0)
    turned = [
        replace(each, orientations=rotations.compose(turns, each.orientations)) for each in shown
    ]
    plain, other = (lt.ProMP().fit(each).generate() for each in (shown, turned))
    expected = rotations.compose(np.repeat(turn, len(plain.times), axis=0), plain.orientations)
    assert rotations.distance(other.orientations, expected).max() < 1e-7


def test_pose_via_point_and_samples():
    skill = lt.ProMP().fit(turning())
    mean = skill.generate(dt=0.1)
    turned = rotations.compose(mean.orientations[[15]], rotations.exp([[0.1, 0.0, 0.0]]))[0]
    via = skill.condition(mean.times[15], (mean.positions[15], turned))
    reached = via.generate(dt=0.1).orientations[[15]]
    assert rotations.distance(reached, turned[None])[0] < 1e-7
    assert all(isinstance(each, lt.PoseTrajectory) for each in skill.sample(2, seed=0))
    assert skill.log_likelihood(turning(1, seed=5)[0]) > -np.inf


def test_components_have_mean_orientations_on_the_sphere():
    skill = lt.GMR(6).fit(turning())
    means = skill.component_orientations()
    np.testing.assert_allclose(np.linalg.norm(means, axis=1), 1.0, atol=1e-12)
    times = skill.mixture.means[:, 0]
    expected = rotations.exp(np.outer(5.0 * times / 3.0, [0.1, 0.2, 1.0] / np.sqrt(1.05)))
    assert rotations.distance(means, expected).max() < 0.3
    points = [lt.Trajectory(U, np.column_stack([U, U]))]
    with pytest.raises(UnsupportedQuery):
        lt.GMR(2).fit(points).component_orientations()


LEARNERS = (
    kind("DMP", "poses"),
    kind("ProMP", "poses", weights=8),
    kind("GMR", "poses", components=4),
    kind("TaskGMR", "poses", components=3),
    kind("FastMarching", "poses"),
)


def turned_to(degrees, *, at=U, aside=0.0):
    """A pose that turns by an angle about z, at some fractions of its way."""
    bow = 0.1 * np.sin(np.pi * U)
    points = np.column_stack([0.3 * U, bow + aside, 0.1 * U])
    turned = rotations.exp(np.outer(at, [0.0, 0.0, np.radians(degrees)]))
    return lt.PoseTrajectory(2.0 * U, points, turned)


@pytest.fixture(params=LEARNERS, ids=str)
def model(request):
    return request.param.build()


GROUPS = [(170.0, -168.0, 165.0, -170.0), (120.0, -120.0, 110.0, -115.0)]


@pytest.mark.parametrize("angles", GROUPS)
def test_two_groups_without_a_mean_are_modes_in_any_order_or_named(model, angles):
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 0, 3, 2]):
        shown = [turned_to(angles[i]) for i in order]
        if isinstance(model, TaskGMR | lt.FastMarching):
            first, second = sorted(
                [k for k, i in enumerate(order) if side * angles[i] > 0.0] for side in (1, -1)
            )
            with pytest.raises(FitError, match="fit each group alone") as caught:
                model.fit(shown)
            assert f"{first} and {second} turn up to" in str(caught.value)
            continue
        skill = model.fit(shown)
        assert len(skill.modes) == 2
        for side in (1.0, -1.0):
            wanted = turned_to(float(np.mean([each for each in angles if each * side > 0.0])))
            made = skill.generate(goal=(wanted.positions[-1], wanted.orientations[-1]))
            halfway, middle = (m.orientations[[len(m.times) // 2]] for m in (made, wanted))
            assert rotations.distance(halfway, middle)[0] < 0.1


def test_a_mean_does_not_depend_on_the_order(model):
    shown = [turned_to(angle) for angle in (130.0, 80.0, 20.0, -10.0)]
    one, other = (model.fit(each).generate() for each in (shown, shown[::-1]))
    # A mixture starts from points drawn at random, in the order of the demonstrations.
    assert rotations.distance(one.orientations, other.orientations).max() < 0.05
    assert rotations.distance(one.orientations[-1:], turned_to(55.0).orientations[-1:]) < 0.05


def test_a_spread_beyond_a_quarter_turn_has_no_mean_but_a_middle_for_frames():
    angles = (95.0, 60.0, -20.0, -95.0)
    for order in (angles, angles[::-1]):
        shown = [turned_to(angle) for angle in order]
        for family in ("DMP", "ProMP", "GMR"):
            assert len(kind(family, "poses").build().fit(shown).modes) == 2
        with pytest.raises(FitError, match=r"\[0, 1\] and \[2, 3\] turn up to 1.. degrees apart"):
            lt.FastMarching().fit(shown)
    ends = [
        TaskGMR(components=3)
        .fit([turned_to(angle) for angle in order])
        .generate()
        .orientations[-1:]
        for order in (angles, angles[::-1])
    ]
    assert rotations.distance(*ends)[0] < 1e-6


def test_the_same_turning_at_other_times_is_aligned():
    early, late = np.clip(3.0 * U, 0.0, 1.0), np.clip(3.0 * U - 2.0, 0.0, 1.0)
    shown = []
    for at in (early, late, early):
        points = np.column_stack([0.3 * at, 0.1 * np.sin(np.pi * at), 0.1 * at])
        turned = rotations.exp(np.outer(at, [0.0, 0.0, np.radians(200.0)]))
        shown.append(lt.PoseTrajectory(2.0 * U, points, turned))
    made = kind("DMP", "poses").build().fit(shown).generate()
    turns = rotations.distance(made.orientations[1:], made.orientations[:-1])
    assert np.degrees(turns.sum()) == pytest.approx(200.0, abs=2.0)


def test_ways_apart_may_turn_differently_in_fast_marching():
    near, far = turned_to(170.0), turned_to(-170.0, aside=0.5)
    skill = lt.FastMarching().fit([near, near, far], outliers="keep")
    for shown in (near, far):
        made = skill.generate(start=shown.positions[0], goal=shown.positions[-1])
        middle = made.orientations[[len(made.times) // 2]]
        assert rotations.distance(middle, shown.orientations[[60]])[0] < 0.3


@pytest.mark.parametrize("model", [lt.DMP(), lt.ProMP()], ids=["DMP", "ProMP"])
def test_one_that_starts_rotated_as_no_other_does_is_named_and_dropped_on_request(
    model, recordings
):
    one, _, *others = read(recordings / "strokes" / "puma-tomato1.npz")
    with pytest.raises(FitError, match=r"\[0\] and \[1, 2, 3\] turn up to 149 degrees apart"):
        model.fit([one, *others])
    kept = model.fit([one, *others], outliers="drop").generate()
    np.testing.assert_array_equal(kept.orientations, model.fit(others).generate().orientations)
