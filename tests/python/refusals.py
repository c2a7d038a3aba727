"""Calls that fail, in a line each."""

import re

import pytest

from leadthrough.errors import InvalidInput


def raised(kind, call, /, *args, **options):
    """The error of this kind that a call raises."""
    with pytest.raises(kind) as caught:
        call(*args, **options)
    return caught.value


def refused(words, call, /, *args, **options):
    """That a call raises InvalidInput about this argument, or in words of this pattern."""
    error = raised(InvalidInput, call, *args, **options)
    assert error.argument == words or re.search(words, str(error)), error
