"""`--help` of every command: fast, and as wide as a terminal."""

import resource
import subprocess
import sys

import pytest
import typer
from cli.command_line import run

from leadthrough import cli

COMMANDS = typer.main.get_command(cli.app).commands
PROGRAM = [sys.executable, "-m", "leadthrough", "--help"]
MOST = 0.5  # s of processor time
ATTEMPTS = 3


def processor_time_of_help():
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(PROGRAM, check=True, capture_output=True, timeout=60)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_help_is_there_at_once():
    assert min(processor_time_of_help() for _ in range(ATTEMPTS)) <= MOST


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_and_begins_with_a_sentence(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run(name, "--help").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert COMMANDS[name].help.split("\n\n")[0].endswith(".")
    for parameter in COMMANDS[name].params:
        assert parameter.help, f"{name} {parameter.opts[0]}"
        assert parameter.help.endswith("."), f"{name} {parameter.opts[0]}: {parameter.help}"
