"""Demonstrations whose orientations have a mean, or have none, in every model of poses."""

import numpy as np
import pytest
from kinds import kind

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError
from leadthrough.models import TaskGMR
from leadthrough.models.mean_orientation import mean_orientations
from leadthrough.preprocess import align_by_time_warping

U = np.linspace(0.0, 1.0, 120)
LEARNERS = (
    kind("DMP", "poses"),
    kind("ProMP", "poses", weights=8),
    kind("GMR", "poses", components=4),
    kind("TaskGMR", "poses", components=3),
    kind("FastMarching", "poses"),
)


def turning(degrees, *, at=U, aside=0.0):
    """A pose that turns by an angle about z, at some fractions of its way."""
    bow = 0.1 * np.sin(np.pi * U)
    points = np.column_stack([0.3 * U, bow + aside, 0.1 * U])
    turned = rotations.exp(np.outer(at, [0.0, 0.0, np.radians(degrees)]))
    return lt.Demonstration(lt.PoseTrajectory(2.0 * U, points, turned))


@pytest.fixture(params=LEARNERS, ids=str)
def model(request):
    return request.param.build()


@pytest.mark.parametrize("angles", [(170.0, -168.0, 165.0, -170.0), (179.0, -95.0, 100.0, -90.0)])
def test_two_groups_without_a_mean_are_named_in_any_order(model, angles):
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 0, 3, 2]):
        shown = [turning(angles[i]) for i in order]
        one = [k for k, i in enumerate(order) if angles[i] > 0.0]
        other = [k for k, i in enumerate(order) if angles[i] < 0.0]
        first, second = sorted([one, other])
        with pytest.raises(FitError) as caught:
            model.fit(shown)
        assert f"{first} and {second} turn up to" in str(caught.value)
        told = float(str(caught.value).split(" turn up to ")[1].split(" degrees")[0])
        assert 174.0 <= told <= 180.0
        assert "fit each group alone" in str(caught.value)


def test_a_mean_does_not_depend_on_the_order(model):
    shown = [turning(angle) for angle in (130.0, 80.0, 20.0, -10.0)]
    one, other = (model.fit(each).generate() for each in (shown, shown[::-1]))
    # A mixture starts from points drawn at random, in the order of the demonstrations.
    assert rotations.distance(one.orientations, other.orientations).max() < 0.05
    assert rotations.distance(one.orientations[-1:], turning(55.0).motion.orientations[-1:]) < 0.05


def test_a_spread_beyond_a_quarter_turn_has_no_mean_but_a_middle_for_frames():
    angles = (95.0, 60.0, -20.0, -95.0)
    for order in (angles, angles[::-1]):
        for family in ("DMP", "ProMP", "GMR", "FastMarching"):
            model = kind(family, "poses").build()
            with pytest.raises(
                FitError, match=r"\[0, 1\] and \[2, 3\] turn up to 1.. degrees apart"
            ):
                model.fit([turning(angle) for angle in order])
    ends = [
        TaskGMR(components=3).fit([turning(angle) for angle in order]).generate().orientations[-1:]
        for order in (angles, angles[::-1])
    ]
    assert rotations.distance(*ends)[0] < 1e-6


def test_the_mean_never_jumps_between_samples_that_have_one():
    """Both sides come within a quarter turn of the mean again, beyond the half turn."""
    layers = [turning(angle).motion.orientations for angle in (170.0, -170.0)]
    for i in (0, -1):
        rotations.mean(np.stack([each[[i]] for each in layers]))
    coarse = [each[[0, 40, -1]] for each in layers]
    assert rotations.distance(coarse[0], coarse[1]).max() < np.pi
    with pytest.raises(FitError, match="no mean orientation"):
        mean_orientations([each[::7] for each in layers])


def test_the_same_turning_at_other_times_is_told_with_its_cure():
    early, late = np.clip(3.0 * U, 0.0, 1.0), np.clip(3.0 * U - 2.0, 0.0, 1.0)
    shown = []
    for at in (early, late, early):
        points = np.column_stack([0.3 * at, 0.1 * np.sin(np.pi * at), 0.1 * at])
        turned = rotations.exp(np.outer(at, [0.0, 0.0, np.radians(200.0)]))
        shown.append(lt.PoseTrajectory(2.0 * U, points, turned))
    with pytest.raises(FitError, match=r"\[0, 2\] and \[1\].*align_by_time_warping"):
        kind("DMP", "poses").build().fit(shown)
    made = kind("DMP", "poses").build().fit(align_by_time_warping(shown)).generate()
    turns = rotations.distance(made.orientations[1:], made.orientations[:-1])
    assert np.degrees(turns.sum()) == pytest.approx(200.0, abs=2.0)


def test_ways_apart_may_turn_differently_in_fast_marching():
    near, far = turning(170.0), turning(-170.0, aside=0.5)
    skill = lt.FastMarching().fit([near, near, far])
    for shown in (near.motion, far.motion):
        made = skill.generate(start=shown.positions[0], goal=shown.positions[-1])
        middle = made.orientations[[len(made.times) // 2]]
        assert rotations.distance(middle, shown.orientations[[60]])[0] < 0.3
