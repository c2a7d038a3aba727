"""Checks of arguments, and errors that name them."""

import inspect
import pickle
import re
from dataclasses import dataclass, fields, is_dataclass
from functools import partial

import numpy as np
import pytest
from contracts.public import public_callables
from hypothesis import given, strategies as st
from refusals import raised, refused

from leadthrough import check, errors
from leadthrough.errors import InvalidInput

COUNT = partial(check.integer, at_least=1, at_most=10)
SIDE = partial(check.choice, options=("left", "right"))


def test_array_accepts_lists_and_any_real_dtype():
    for value in ([[1, 2], [3, 4]], np.ones((2, 2), np.float32), np.ones((2, 2), np.int8)):
        result = check.array(value, "value", shape=("n", 2))
        assert result.dtype == np.float64
        assert result.flags.c_contiguous


def test_array_wants_equal_sizes_where_a_name_stands_twice():
    assert check.array(np.eye(3), "m", shape=("n", "n")).shape == (3, 3)
    refused("m: expected shape", check.array, np.ones((2, 3)), "m", shape=("n", "n"))


def test_frozen_copies_and_the_copy_is_read_only():
    value = np.zeros(3)
    result = check.frozen(value, "value", shape=(3,))
    value[0] = 1.0
    assert result[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        result[0] = 2.0


def test_array_and_times_name_the_argument_and_the_place_at_fault():
    with pytest.raises(InvalidInput, match=re.escape("q: expected shape (n, 7), got (50, 6)")):
        check.array(np.zeros((50, 6)), "q", shape=("n", 7))
    for bad in [np.nan, np.inf, -np.inf]:
        refused(
            r"at index \(1, 0\)", check.array, [[0.0, 0.0], [bad, 0.0]], "value", shape=("n", 2)
        )
        refused("at index 2", check.array, [0.0, 0.0, bad], "value", shape=("n",))
    refused(r"got 2.0 s then 1.0 s at samples 1 and 2", check.times, [0, 2, 1], "times")


def test_quaternions_are_normalised_and_others_refused():
    result = check.quaternions([[1.005, 0, 0, 0]], "q", shape=("n", 4))
    assert np.array_equal(result, [[1, 0, 0, 0]])
    for bad in ([[0, 0, 0, 0]], [[2, 0, 0, 0]], [[1, 0, 0]]):
        refused("q: ", check.quaternions, bad, "q", shape=("n", 4))


@given(st.floats())
def test_number_is_finite_and_inside_its_bounds_or_refused(value):
    if np.isfinite(value) and 0 < value <= 1:
        assert check.number(value, "value", above=0, at_most=1) == value
    else:
        with pytest.raises(InvalidInput, match="value: expected a finite number > 0 and <= 1"):
            check.number(value, "value", above=0, at_most=1)


NO_NUMBERS = [[True, False], ["1", "2"], [1j, 2], [None, 1], [[1], [1, 2]], "12", None, {1: 2}]
NO_TIMES = [[0, 0], [1, 0], [0, 1, 1, 2], [], [0, np.nan], [[0, 1]], 3.0, [-1.5e308, 0, 1.5e308]]


@pytest.mark.parametrize(
    ("checked", "value"),
    [
        *((partial(check.array, shape=("n",)), value) for value in NO_NUMBERS),
        *((check.times, value) for value in NO_TIMES),
        *((check.number, value) for value in (True, "1", b"1", None, [1.0, 2.0], 10**400, 1j)),
        *((COUNT, value) for value in (1.0, "1", True, None, 0, 11)),
        *((SIDE, value) for value in ("up", None, 1, ["left"])),
        (partial(check.affordable_count, each=10**6), 1000),
        *((partial(check.names, count=2), value) for value in ("ab", 3, [1, 2], ["a"])),
    ],
)
def test_wrong_values_are_refused_with_the_name_of_the_argument(checked, value):
    with pytest.raises(InvalidInput, match=r"^given: expected .*, got ") as error:
        checked(value, "given")
    assert error.value.argument == "given"
    assert error.value.value in (value, None)


def test_a_refused_number_or_text_is_at_hand():
    for value in (1.5, 7, "up"):
        assert raised(InvalidInput, check.choice, value, "side", ("left", "right")).value == value


def test_integer_takes_numpy_integers():
    assert check.integer(np.int32(3), "count", at_least=1) == 3


def test_choice_lists_the_options():
    refused("side: expected one of 'left', 'right', got 'up'", SIDE, "up", "side")
    assert SIDE("left", "side") == "left"


def test_numbers_of_numpy_are_shown_as_numbers():
    for call, told in (
        (lambda: check.number(np.float64(3.5), "x", above=np.float64(4.0)), "> 4.0, got 3.5"),
        (lambda: check.number(np.float64("nan"), "x"), "got nan"),
        (lambda: check.number(np.bool_(True), "x"), "got True"),
        (lambda: check.integer(np.float64(3.5), "x", at_least=1), "got 3.5"),
        (lambda: check.choice(np.str_("a"), "x", ("b",)), "got 'a'"),
    ):
        assert str(raised(InvalidInput, call)).endswith(told)


EXAMPLES = [
    errors.SchedulerUnreachable("on: no answer"),
    errors.CodeMismatch("on: other code"),
    errors.InvalidInput("message"),
    errors.UnsupportedQuery("message"),
    errors.FitError("message"),
    errors.NotFitted("message"),
    errors.NoPath("message", reason="goal_enclosed"),
    errors.NoContinuousLogarithm("message", index=3),
    errors.IkFailure("message", index=3, status="stuck", residual=(0.1, 0.2), q=np.zeros(2)),
    errors.LimitsInfeasible("message", joint="elbow"),
    errors.InvalidRobot("joint elbow", "no limit"),
    errors.MissingDependency("websockets", extra="view"),
]


def test_every_error_is_a_leadthrough_error():
    classes = [value for _, value in inspect.getmembers(errors, inspect.isclass)]
    raised = [value for value in classes if issubclass(value, BaseException)]
    assert all(issubclass(value, errors.LeadthroughError) for value in raised)
    assert {type(example) for example in EXAMPLES} == {*raised} - {errors.LeadthroughError}


def test_wrong_input_is_also_a_value_error():
    assert issubclass(errors.InvalidInput, ValueError)
    assert issubclass(errors.UnsupportedQuery, errors.InvalidInput)
    assert issubclass(errors.InvalidRobot, ValueError)


def test_errors_carry_their_evidence():
    by_type = {type(example): example for example in EXAMPLES}
    assert by_type[errors.NoPath].reason == "goal_enclosed"
    assert by_type[errors.IkFailure].index == 3
    assert by_type[errors.LimitsInfeasible].joint == "elbow"
    assert str(by_type[errors.InvalidRobot]) == "joint elbow: no limit"
    assert "pip install 'leadthrough[view]'" in str(by_type[errors.MissingDependency])


@pytest.mark.parametrize("error", EXAMPLES, ids=lambda error: type(error).__name__)
def test_errors_travel_between_processes(error):
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert copy.__dict__.keys() == error.__dict__.keys()


@pytest.mark.parametrize(
    ("message", "argument"),
    [
        ("rate: needed, the file has no time", "rate"),
        ("recorded/day 3.csv: rate: needed", "rate"),
        ("day.csv: line 3: angles: joints reach 7", "angles"),
        ("frames[2]: expected 3 dimensions, got 2", "frames[2]"),
        ("columns['joints']: no column 'q7'; there are: q1", "columns['joints']"),
        ("no path from here to there: too narrow", None),
    ],
)
def test_an_error_knows_the_argument_that_its_message_names(message, argument):
    assert errors.InvalidInput(message).argument == argument


def test_large_arrays_are_told_by_their_shape_and_small_ones_by_their_numbers():
    @dataclass(frozen=True, eq=False)
    class Answer(check.ShortRepr):
        small: object
        large: object
        names: object

    text = repr(Answer(np.array([0.25, -1e-20]), np.zeros((50, 7)), tuple("abcdefg")))
    assert text == "Answer(small=(0.25, 0), large=array (50, 7), names=('a' ... 'g', 7 in all))"


def test_long_values_are_cut_off():
    @dataclass(frozen=True, eq=False)
    class Answer(check.ShortRepr):
        words: object

    assert len(repr(Answer("word " * 500))) < 100


def test_a_class_keeps_its_own_repr():
    class Answer(check.ShortRepr):
        def __repr__(self):
            return "mine"

    assert repr(Answer()) == "mine"


def test_public_results_with_arrays_are_frozen_too():
    for name, value in public_callables():
        if inspect.isclass(value) and is_dataclass(value):
            holds = any("Array" in str(each.type) for each in fields(value))
            assert not holds or issubclass(value, check.Frozen), name
