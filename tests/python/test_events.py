import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough import events
from leadthrough.errors import InvalidInput
from leadthrough.events import Event


def at(*pairs):
    return tuple(Event(time, name) for time, name in pairs)


def test_motions_sort_their_events_and_demonstrations_show_them():
    motion = lt.Trajectory([1.0, 2.0], [[0.0], [1.0]], at((2.0, "opened"), (1.0, "closed")))
    assert motion.events == at((1.0, "closed"), (2.0, "opened"))
    assert lt.Demonstration(motion).events == motion.events
    assert lt.Trajectory([1.0, 2.0], [[0.0], [1.0]], [Event(1.5, "a")]).events == at((1.5, "a"))


@pytest.mark.parametrize(("time", "name"), [(np.nan, "a"), ("now", "a"), (0.0, " "), (0.0, 3)])
def test_events_without_a_time_or_a_name_are_refused(time, name):
    with pytest.raises(InvalidInput, match=r"time|name"):
        Event(time, name)


@pytest.mark.parametrize(
    "wrong", [at((2.1, "late")), at((0.9, "early")), "closed", 3, None, [(1.0, "closed")]]
)
def test_events_outside_of_their_motion_and_other_things_are_refused(wrong):
    with pytest.raises(InvalidInput, match="events"):
        lt.Trajectory([1.0, 2.0], [[0.0], [1.0]], wrong)


def test_moved_events_come_as_soon_as_the_new_clock_gets_there():
    old, new = [0.0, 1.0, 1.0, 2.0], [10.0, 11.0, 13.0, 14.0]
    found = events.moved(at((0.5, "a"), (1.0, "b"), (1.5, "c"), (2.0, "d")), old, new)
    assert found == at((10.5, "a"), (11.0, "b"), (13.5, "c"), (14.0, "d"))


@given(st.lists(st.floats(0.0, 1.0), max_size=8), st.floats(0.1, 100.0), st.floats(-10.0, 10.0))
def test_events_that_move_there_and_back_are_where_they_were(times, scale, shift):
    old = np.linspace(0.0, 1.0, 5)
    new = shift + scale * old**2
    before = tuple(Event(time, "x") for time in sorted(times))
    moved = events.moved(before, old, new)
    assert all(new[0] <= event.time <= new[-1] for event in moved)
    back = events.moved(moved, new, old)
    np.testing.assert_allclose(
        [event.time for event in back], [event.time for event in before], atol=1e-6
    )


def test_most_demonstrations_decide_what_happens_and_their_mean_when():
    shown = [
        at((0.2, "closed"), (0.5, "opened"), (0.6, "closed")),
        at((0.4, "closed"), (0.7, "opened"), (0.8, "closed")),
        at((0.3, "closed"), (0.9, "dropped")),
    ]
    found = events.agreed(shown)
    assert [event.name for event in found] == ["closed", "opened", "closed"]
    np.testing.assert_allclose([event.time for event in found], [0.3, 0.6, 0.7])
    assert events.agreed(shown[:2] + [()] * 2) == ()  # half is not most
    (only,) = events.agreed([at((0.2, "a")), at((0.6, "a")), ()], [1.0, 3.0, 2.0])
    assert only.time == pytest.approx(0.5)


def test_rounds_are_cut_and_repeated():
    happened = at((0.25, "a"), (1.25, "a"), (2.0, "b"))
    assert events.by_round(happened, 0.0, 2.0) == [at((0.25, "a")), at((0.25, "a"), (1.0, "b"))]
    assert events.every_round(at((0.25, "a")), 2.2) == at((0.25, "a"), (1.25, "a"))


def test_plain_values_come_back():
    happened = at((0.1, "closed"), (1.0 / 3.0, "opened"))
    assert events.from_plain(events.to_plain(happened)) == happened
