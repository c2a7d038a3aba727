"""Runs a command line in this process, as the tests of the commands do."""

import json

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
