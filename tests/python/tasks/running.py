"""Programs that the tests of the engine start and end."""

import os
import subprocess
import sys
import time

ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, sys.path))}


def program(*words, log):
    """A module of Python as a program, whose messages go to a file."""
    with log.open("ab") as file:
        return subprocess.Popen(
            [sys.executable, "-m", *map(str, words)],
            env=ENVIRONMENT,
            stdout=file,
            stderr=subprocess.STDOUT,
        )


def started(out, on):
    """The study `of_numbers` as a program, some of whose tasks are done."""
    out.mkdir()
    client = program("tasks.of_numbers", out, on, log=out / "messages")
    # Files with a leading dot are still being written.
    wait(lambda: len(list(out.glob("cache/??/[!.]*.json"))) >= 3, client, out / "messages")
    return client


def wait(until, process, log, seconds=60.0):
    """Waits for something that a process does."""
    deadline = time.monotonic() + seconds
    while not until():
        assert process.poll() is None and time.monotonic() < deadline, log.read_text()
        time.sleep(0.02)
