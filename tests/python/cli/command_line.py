"""Runs a command line in this process, as the tests of the commands do; files to run it on."""

import json
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from leadthrough import cli

RUNNER = CliRunner()


def run(*words, code=0):
    """The command's result, if it ends with the code."""
    result = RUNNER.invoke(cli.app, [str(word) for word in words])
    assert result.exit_code == code, result.output
    return result


def facts(*words, code=0):
    """The command's JSON, if it ends with the code."""
    return json.loads(run(*words, "--json", code=code).stdout)


def write_table(path, header, rows):
    """A recording as a table, its columns named as in the header; and its path."""
    np.savetxt(path, rows, delimiter=",", header=header, comments="")
    return path


def write_limits(path, joint_names, head=""):
    """A limits file with an acceleration and a jerk of each joint."""
    rows = (f"{name} = {{ acceleration = 10.0, jerk = 100.0 }}\n" for name in joint_names)
    Path(path).write_text(f"{head}[joints]\n{''.join(rows)}")
