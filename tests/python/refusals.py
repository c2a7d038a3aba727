"""Refused arguments, in a line each."""

import re

import pytest

from leadthrough.errors import InvalidInput


def refused(words, call, /, *args, **options):
    """That a call raises InvalidInput about this argument, or in words of this pattern."""
    with pytest.raises(InvalidInput) as caught:
        call(*args, **options)
    assert caught.value.argument == words or re.search(words, str(caught.value)), caught.value
