"""Panels as a small inline SVG, for light and for dark pages: texts have the page's own colour."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from leadthrough.drawing.panels import Dot, Line, Numbers, Panel

_WIDTH, _HEIGHT = 300, 200  # of a panel, px
_LEFT, _RIGHT, _TOP, _BOTTOM = 44, 12, 40, 34  # around the axes
_NAME_WIDTH = 110  # for the names of rows
_LETTER = 5.6  # width of a letter on average
_MOST_POINTS = 200  # of a line; more are not seen at this size
_TICKS = 4
_PAD = 0.05  # of the range, around the lines


def drawing(panels: Sequence[Panel]) -> str:
    """An SVG element with the panels side by side."""
    width = _WIDTH * len(panels)
    content = "".join(
        f'<g transform="translate({_WIDTH * i} 0)">{"".join(_panel(panel))}</g>'
        for i, panel in enumerate(panels)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {_HEIGHT}" width="{width}" '
        f'style="max-width:100%;height:auto" font-family="system-ui,sans-serif" font-size="10" '
        f'fill="currentColor">{content}</svg>'
    )


@dataclass(frozen=True)
class _Axis:
    """From numbers to pixels."""

    low: float
    high: float
    start: float
    end: float

    def __call__(self, value: Numbers | float) -> Numbers:
        part = (np.asarray(value) - self.low) / (self.high - self.low)
        return np.asarray(self.start + part * (self.end - self.start))


def _panel(panel: Panel) -> Iterator[str]:
    left = _NAME_WIDTH if panel.rows else _LEFT
    x, y = _axes(panel, left)
    yield _text(8, 14, panel.title, weight="600")
    yield from _legend(panel)
    if not panel.equal:
        yield from _ticks(panel, x, y, left)
    for at, text in panel.marks:
        yield _rule(float(x(at)), _TOP, float(x(at)), _HEIGHT - _BOTTOM, dash="3 3")
        yield _text(float(x(at)) + 3, _TOP + 8, text, opacity=0.7)
    for band in panel.bands:
        edge = np.concatenate([band.lower, band.upper[::-1]])
        around = _points(x(np.concatenate([band.x, band.x[::-1]])), y(edge), thin=False)
        yield f'<polygon points="{around}" fill="{panel.colour(band.line)}" opacity="0.22"/>'
    for i, line in enumerate(panel.lines):
        yield _polyline(line, panel.colour(i), x, y)
    for dot in panel.dots:
        yield from _dot(dot, float(x(dot.x)), float(y(dot.y)))


def _axes(panel: Panel, left: float) -> tuple[_Axis, _Axis]:
    (x_low, x_high), (y_low, y_high) = _range(panel, "x"), _range(panel, "y")
    inside = (left, _WIDTH - _RIGHT), (_HEIGHT - _BOTTOM, _TOP)
    if panel.rows:
        return _Axis(x_low, x_high, *inside[0]), _Axis(len(panel.rows) - 0.5, -0.5, *inside[1])
    if panel.equal:
        wide, high = _WIDTH - left - _RIGHT, _HEIGHT - _BOTTOM - _TOP
        scale = max((x_high - x_low) / wide, (y_high - y_low) / high)
        spare_x, spare_y = scale * wide - (x_high - x_low), scale * high - (y_high - y_low)
        x_low, x_high = x_low - 0.5 * spare_x, x_high + 0.5 * spare_x
        y_low, y_high = y_low - 0.5 * spare_y, y_high + 0.5 * spare_y
    return _Axis(x_low, x_high, *inside[0]), _Axis(y_low, y_high, *inside[1])


def _range(panel: Panel, name: str) -> tuple[float, float]:
    values = [getattr(each, name) for each in panel.lines]
    values += [np.array([getattr(dot, name)]) for dot in panel.dots]
    if name == "y":
        values += [edge for band in panel.bands for edge in (band.lower, band.upper)]
    numbers = np.concatenate(values)
    numbers = numbers[np.isfinite(numbers)]
    low, high = (float(numbers.min()), float(numbers.max())) if len(numbers) else (0.0, 1.0)
    if high - low < 1e-9 * max(abs(low), abs(high), 1e-3):
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    pad = 0.0 if name == "x" and not panel.equal else _PAD * (high - low)
    return low - pad, high + pad


def _ticks(panel: Panel, x: _Axis, y: _Axis, left: float) -> Iterator[str]:
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    yield _rule(left, bottom, right, bottom)
    for value in _round_numbers(x.low, x.high):
        at = float(x(value))
        yield _rule(at, bottom, at, bottom + 3)
        yield _text(at, bottom + 14, f"{value:.6g}", anchor="middle", opacity=0.75)
    yield _text(0.5 * (left + right), bottom + 28, panel.x_label, anchor="middle", opacity=0.75)
    if panel.rows:
        for row, name in enumerate(panel.rows):
            yield _text(left - 6, float(y(row)) + 3, name, anchor="end", opacity=0.75)
        return
    for value in _round_numbers(y.low, y.high):
        at = float(y(value))
        yield _rule(left, at, right, at, opacity=0.12)
        yield _text(left - 5, at + 3, f"{value:.6g}", anchor="end", opacity=0.75)


def _round_numbers(low: float, high: float) -> Numbers:
    """The multiples of 1, 2 or 5 times a power of ten between two numbers, about four of them."""
    rough = (high - low) / _TICKS
    power = 10.0 ** np.floor(np.log10(rough))
    step = power * min((1.0, 2.0, 5.0, 10.0), key=lambda part: abs(part * power - rough))
    first = np.ceil(low / step)
    found = step * np.arange(first, np.floor(high / step) + 1)
    return np.asarray(np.where(np.abs(found) < 1e-9 * step, 0.0, found))


def _legend(panel: Panel) -> Iterator[str]:
    named = [(i, line.name) for i, line in enumerate(panel.lines) if line.name]
    if len(named) < 2:
        return
    at = 8.0
    for i, name in named:
        if at + _LETTER * (len(name) + 2) > _WIDTH:
            yield _text(at, 28, "...", opacity=0.75)
            return
        yield f'<rect x="{at:.1f}" y="21.5" width="8" height="3" fill="{panel.colour(i)}"/>'
        yield _text(at + 11, 27, name, opacity=0.85)
        at += 11 + _LETTER * (len(name) + 1.5)


def _polyline(line: Line, colour: str, x: _Axis, y: _Axis) -> str:
    dash = ' stroke-dasharray="4 3"' if line.dashed else ""
    return (
        f'<polyline points="{_points(x(line.x), y(line.y))}" fill="none" stroke="{colour}" '
        f'stroke-width="{line.width:g}" stroke-linejoin="round"{dash}/>'
    )


def _dot(dot: Dot, x: float, y: float) -> Iterable[str]:
    if dot.radius:
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{dot.radius:g}" fill="{dot.colour}"/>'
    if dot.text:
        yield _text(x + dot.radius + 2, y + 3, dot.text, opacity=0.75)


def _points(x: Numbers, y: Numbers, *, thin: bool = True) -> str:
    kept = np.isfinite(x) & np.isfinite(y)
    x, y = x[kept], y[kept]
    if thin and len(x) > _MOST_POINTS:
        chosen = np.linspace(0, len(x) - 1, _MOST_POINTS).round().astype(int)
        x, y = x[chosen], y[chosen]
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _rule(
    x1: float, y1: float, x2: float, y2: float, *, opacity: float = 0.4, dash: str = ""
) -> str:
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="currentColor" '
        f'opacity="{opacity:g}"{dashes}/>'
    )


def _text(
    x: float, y: float, text: str, *, anchor: str = "start", opacity: float = 1.0, weight: str = ""
) -> str:
    if not text:
        return ""
    heavy = f' font-weight="{weight}"' if weight else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" opacity="{opacity:g}"{heavy}>'
        f"{escape(text)}</text>"
    )
