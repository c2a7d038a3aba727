"""Messages of the whole package: advice for those who program comes last, after "in Python"."""

import ast
import re
from pathlib import Path

import pytest

import leadthrough
from leadthrough.cli.errors import in_words

PACKAGE = Path(leadthrough.__file__).parent
FUNCTIONS = re.compile(
    r"\b(?:lt|io|timing|preprocess|Arm|arm|skill)\.[a-z]\w*|[A-Za-z_]\w*\((?:\)|\.\.\.)"
)
# Nothing that a command calls raises these.
OF_PYTHON_ONLY = {"models/unfitted.py", "arm/task_stack.py"}
MESSAGES = [
    pytest.param(message, id=f"{path.relative_to(PACKAGE)}:{node.lineno}")
    for path in sorted(PACKAGE.rglob("*.py"))
    if str(path.relative_to(PACKAGE)) not in OF_PYTHON_ONLY
    for node in ast.walk(ast.parse(path.read_text()))
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args
    if FUNCTIONS.search(message := "".join(
        part.value
        for part in ast.walk(node.exc)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ))
]  # fmt: skip


def test_there_are_such_messages():
    assert len(MESSAGES) >= 5


@pytest.mark.parametrize("message", MESSAGES)
def test_no_function_is_left_for_a_user_of_commands(message):
    assert not FUNCTIONS.search(in_words(message, {})), message
