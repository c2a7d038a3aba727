"""Texts and drawings of every skill at the prompt and in a notebook."""

from xml.etree import ElementTree

import kinds
import pytest

from leadthrough.errors import NotFitted


@pytest.fixture(scope="module", params=kinds.KINDS)
def skill(request):
    return kinds.learned(request.param)


def test_skill_is_described_in_a_few_lines(skill):
    text = repr(skill)
    assert text.startswith(f"{type(skill).__name__}({type(skill.model).__name__}(")
    assert "supports" in text
    assert len(text.splitlines()) <= 5
    assert max(map(len, text.splitlines())) <= 100


def test_skill_draws_its_motion(skill):
    page = ElementTree.fromstring(skill._repr_html_())
    (picture,) = page.iter("{http://www.w3.org/2000/svg}svg")
    assert picture.get("aria-label") == type(skill).__name__
    assert len(ElementTree.tostring(page)) < 120_000
    axes = skill.plot().axes
    assert sum(len(each.lines) for each in axes) >= 2
    assert any("position" in each.get_title(loc="left") for each in axes)


@pytest.mark.parametrize("name", ["generate", "plot", "save", "supports"])
def test_model_says_that_it_is_to_be_fitted_first(name):
    for each in kinds.KINDS.values():
        model = each.build()
        kind = type(model).__name__
        with pytest.raises(NotFitted, match=rf"{name}: {kind} .* {kind}\(\)\.fit\(demonstrations"):
            getattr(model, name)
        assert not hasattr(model, name)
    with pytest.raises(AttributeError, match="no attribute"):
        getattr(model, name[:3])
