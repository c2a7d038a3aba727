import inspect
import pickle

import numpy as np
import pytest

from leadthrough import errors

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
    errors.MissingDependency("viser", extra="view"),
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
        ("shown/day 3.csv: rate: needed", "rate"),
        ("day.csv: line 3: angles: joints reach 7", "angles"),
        ("frames[2]: expected 3 dimensions, got 2", "frames[2]"),
        ("columns['joints']: no column 'q7'; there are: q1", "columns['joints']"),
        ("no path from here to there: too narrow", None),
    ],
)
def test_an_error_knows_the_argument_that_its_message_names(message, argument):
    assert errors.InvalidInput(message).argument == argument
