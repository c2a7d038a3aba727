"""`--help` of every command, as wide as a terminal."""

import pytest
import typer
from cli.command_line import run

from leadthrough import cli

COMMANDS = typer.main.get_command(cli.app).commands


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_and_begins_with_a_sentence(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = run(name, "--help").stdout
    assert max(map(len, text.splitlines())) <= 80
    assert COMMANDS[name].help.split("\n\n")[0].endswith(".")
    for parameter in COMMANDS[name].params:
        assert parameter.help, f"{name} {parameter.opts[0]}"
        assert parameter.help.endswith("."), f"{name} {parameter.opts[0]}: {parameter.help}"
