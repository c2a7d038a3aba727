"""The fuzzer itself: it reports calls that end their process."""

import faulthandler
import os
import signal

from bindings.fuzz import Call, first_outcomes


def call(function, *arguments):
    return Call(function.__name__, function, list(arguments), {})


def run_out_of_time():
    os.kill(os.getpid(), signal.SIGXCPU)


def abort_quietly():
    faulthandler.disable()
    os.abort()


def test_outcomes_end_with_the_call_that_ends_its_process():
    fine, refused = call(abs, -1), call(abs, "x")
    assert first_outcomes([fine, refused, fine]) == (["answered", "refused", "answered"], "")
    assert first_outcomes([fine, call(abort_quietly), fine])[0] == ["answered", "crashed"]
    assert first_outcomes([call(os._exit, 0), fine])[0] == ["crashed"]
    assert first_outcomes([call(run_out_of_time)])[0] == ["hung"]
