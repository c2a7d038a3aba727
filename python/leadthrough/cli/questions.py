"""Questions of `leadthrough start` about recordings: only those that the files leave open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import leadthrough as lt
from leadthrough import check
from leadthrough.cli import options, parse, robot as robots
from leadthrough.io.guesses import guessed
from leadthrough.io.headers import AngleUnit
from leadthrough.io.recording import recording
from leadthrough.io.table import ANGLES, ORDERS, Request, Table
from leadthrough.preprocess.clean import summarize

Ask = Callable[[str, str | None], str]


def taken(question: str, proposal: str | None) -> str:
    if proposal is None:
        raise lt.errors.InvalidInput(
            f"--yes: there is no proposal for the {question}; give the option, or leave --yes out"
        )
    print(f"{question}: {proposal}")
    return proposal


def asked(question: str, proposal: str | None) -> str:
    """The answer to a question on the terminal; an empty one is the proposal."""
    try:
        answer = input(f"{question}{f' [{proposal}]' if proposal else ''}: ").strip()
    except EOFError:
        raise lt.errors.InvalidInput(
            "--yes: nobody answers questions here; add it to take all proposals"
        ) from None
    return answer or proposal or asked(question, proposal)


def settled(
    ask: Ask, arm: lt.Arm, table: Table, layout: options.ReadOptions
) -> options.ReadOptions:
    """The options by which recordings are read, asked for where the first one leaves them open."""
    request = layout.request(joints=robots.ranges(arm))
    try:
        found = recording(table, request)
    except lt.errors.InvalidInput as error:
        topic = str(error.argument).partition("[")[0]
        return settled(ask, arm, table, _answered(ask, topic, error, table, request, layout))
    if layout.angles or found.joint_names is None or _fits(arm, found):
        return layout
    if not _fits(arm, recording(table, replace(request, angles="degrees"))):
        return layout  # `learn` names the joint that is beyond its limits
    return replace(layout, angles=_unit(ask))


def _answered(
    ask: Ask,
    topic: str,
    error: lt.errors.InvalidInput,
    table: Table,
    request: Request,
    layout: options.ReadOptions,
) -> options.ReadOptions:
    """The options with an answer to what an error leaves open; the error, if that is stated."""
    if topic == "columns" and not layout.column and (named := guessed(table, request)):
        if ask is taken and len(table.names) > sum(map(len, named.values())) + 1:
            raise error  # columns would be left out besides one of times
        column = [
            f"{role}={ask(f'columns of {role} (--column)', ','.join(names))}"
            for role, names in named.items()
        ]
        return replace(layout, column=column)
    if topic == "rate" and layout.rate is None:
        return replace(
            layout, rate=float(parse.numbers(ask("rate in Hz (--rate)", None), "rate")[0])
        )
    if topic == "angles" and layout.angles is None:
        return replace(layout, angles=_unit(ask))
    if topic == "quaternions" and layout.quaternions is None:
        order = ask(f"order of quaternions, {' or '.join(ORDERS)} (--quaternions)", None)
        return replace(layout, quaternions=check.choice(order, "quaternions", ORDERS))
    raise error


def _unit(ask: Ask) -> AngleUnit:
    answer = ask(f"unit of the joints, {', '.join(ANGLES)} (--angles)", "degrees")
    return check.choice(answer, "angles", ANGLES)


def _fits(arm: lt.Arm, found: lt.io.Recording) -> bool:
    """Whether a recording of joints is free of faults and inside the arm's limits."""
    try:
        arm.joints_of(found.motion())
    except lt.errors.InvalidInput:
        return False
    return True


def are_faulty(files: list[Path], layout: options.ReadOptions, arm: lt.Arm) -> bool:
    """Whether a recording has faults that `learn --clean` removes."""
    found = lt.io.read_recordings(files, **layout.arguments(), joints=robots.ranges(arm))
    return any(summarize(each).has_faults for each in found)
