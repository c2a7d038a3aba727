"""What a screen reader needs and the theme leaves out."""

from typing import Any

_SEARCH = '<div class="md-search" data-md-component="search" role="dialog"'


def on_post_page(output: str, **_: Any) -> str:
    return output.replace(_SEARCH, f'{_SEARCH} aria-label="Search"')
