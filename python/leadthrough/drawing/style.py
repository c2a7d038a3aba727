"""The style of all figures: colours, fonts and lines.

Figures are drawn inside `applied`, so that the user's matplotlib settings stay as they are. Figures
of your own have the style after `plt.style.use("leadthrough.drawing.figures")`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from matplotlib import rc_context, rc_params_from_file

# matplotlib's rcParams
STYLE: Any = rc_params_from_file(
    Path(__file__).with_name("figures.mplstyle"), use_default_template=False
)


@contextmanager
def applied() -> Iterator[None]:
    """Gives figures made in the block the package's style; also a decorator."""
    with rc_context(STYLE):
        yield
