"""The table of what each model supports, against the skills."""

import re
import warnings
from pathlib import Path

import kinds
import numpy as np
import pytest
from motions import minimum_jerk, motion_of

from leadthrough import models
from leadthrough.errors import InvalidInput
from leadthrough.models import model_entry, model_names

PAGE = Path(__file__).parents[2] / "docs" / "guide" / "which-model.md"
COLUMNS = ["model", "of", "start", "goal", "obstacles", "via points", "uncertainty", "online"]
SMALL = {"UMIC": {"kernels": 8}, "SEDS": {"components": 2}}  # the others are quick as they are
TIMES = np.linspace(0.0, 2.0, 40)
RISE = minimum_jerk(TIMES / 2.0)


def rows():
    lines = PAGE.read_text().splitlines()
    first = lines.index(f"| {' | '.join(COLUMNS)} |")
    for line in lines[first + 2 :]:
        if not line.startswith("|"):
            return
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        for name in re.findall(r"`(\w+)`", cells[0]):
            yield name, dict(zip(COLUMNS[1:], cells[1:], strict=True))


def demonstrated(kind, number):
    path = np.column_stack([0.4 * RISE, 0.1 * np.sin(np.pi * RISE) + 0.02 * number * RISE])
    if kind == "poses":
        path = np.pad(path, ((0, 0), (0, 1)))
    return motion_of(kind, TIMES, path, np.outer(RISE, [0.3 + 0.02 * number, 0.0, 0.5]))


def fitted(name, kind):
    """The skill of a model, or None if it does not learn motions of this kind."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", models.MisalignmentWarning)
        try:
            model = kinds.kind(name, **SMALL.get(name, {})).build()
            return model.fit([demonstrated(kind, number) for number in range(3)])
        except InvalidInput:
            return None


def supported(skill):
    """The columns of the table, by the skill itself."""
    online = [way for way in ("step", "policy") if hasattr(skill, way)]
    return {
        **{each: "yes" if each in skill.supports else "" for each in ("start", "goal")},
        "obstacles": "yes" if "obstacles" in skill.supports else "",
        "via points": "yes" if "via" in skill.supports or hasattr(skill, "condition") else "",
        "uncertainty": "yes" if hasattr(skill, "distribution") else "",
        "online": ", ".join(online),
    }


@pytest.mark.filterwarnings("ignore:demonstrations. periods")  # a rhythm of a line, bent to close
@pytest.mark.parametrize(("name", "row"), [*rows()], ids=[name for name, _ in rows()])
def test_table_says_what_the_skills_of_a_model_support(name, row):
    skills = {kind: fitted(name, kind) for kind in ("points", "joints", "poses")}
    learned = {kind: skill for kind, skill in skills.items() if skill is not None}
    assert list(learned) == row["of"].split(", ")
    first = next(iter(learned.values()))
    assert supported(first) == {column: row[column] for column in COLUMNS[2:]}


def test_every_model_is_in_the_table():
    registered = {model_entry(name).load().__name__ for name in model_names()}
    assert {name for name, _ in rows()} == registered


def test_every_public_model_is_registered():
    fitting = {name for name in models.__all__ if hasattr(getattr(models, name), "fit")}
    registered = {model_entry(name).load().__name__ for name in model_names()}
    # `Model` is the protocol of all, and `Framed` holds another model.
    assert fitting - registered == {"Framed", "Model"}
