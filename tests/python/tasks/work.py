"""Tasks for the tests of the engine; workers import them by their names."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from leadthrough.tasks import Task


def draws(*, seed, log, wait=0.0):
    """A row of numbers that show each bit; notes in the file `log` that it ran."""
    with Path(log).open("a") as file:
        file.write(f"{seed}\n")
    time.sleep(wait)
    drawn = np.random.default_rng(seed).normal(size=(40, 40))
    return [{"seed": seed, "norm": float(np.linalg.norm(drawn @ drawn)), "first": drawn[0, 0]}]


def ends(*, code):
    """Ends its process: with an exit code, or by a signal where that is negative."""
    if code < 0:
        os.kill(os.getpid(), -code)
    os._exit(code)


def is_killed_once(*, log):
    """A row, unless it is the first to come here: that one is killed."""
    if not Path(log).exists():
        Path(log).write_text("killed")
        os.kill(os.getpid(), signal.SIGKILL)
    return [{"survived": 1}]


def lasts(*, seconds):
    time.sleep(seconds)
    return []


def exits():
    raise SystemExit(3)


def reads(*, recording, times=1):
    """The text of a file, and the suffix of its name."""
    return [{"text": recording.read_text() * times, "suffix": recording.suffix}]


def rows_of(todo, store):
    return [store.rows(task.key) for task in todo]


def draws_of(count, log, wait=0.0):
    return [Task(draws, {"seed": seed, "log": str(log), "wait": wait}) for seed in range(count)]
