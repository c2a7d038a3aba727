"""HTML files of scenes, figures and tables that need no server and no network."""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough.check import Float64Array, ShortRepr
from leadthrough.drawing import palette
from leadthrough.io.files import StrPath, replacing
from leadthrough.shapes.surface import Surface
from leadthrough.show.animation import Animation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SCRIPTS = ("vectors.js", "shaders.js", "painter.js", "pace.js", "curves.js", "scene.js")
_LIVE_SCRIPTS = (*_SCRIPTS, "handles.js", "live.js", "teach.js")
_STYLES = ("page.css",)
_LIVE_STYLES = (*_STYLES, "live.css")
_LEVEL = 5  # of zlib: scenes are no smaller at higher ones, which take up to four times as long


@dataclass(frozen=True, eq=False)
class InlineScene(ShortRepr):
    """A page displayed by a notebook as the result of a cell.

    Attributes:
        title: of the scene.
        document: the page's HTML.
        height: px.
    """

    title: str
    document: str = field(repr=False)
    height: int = 420

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="{html.escape(self.title, quote=True)}" '
            f'style="width: 100%; height: {self.height}px; border: 0" '
            f'srcdoc="{html.escape(self.document, quote=True)}"></iframe>'
        )


def write_page(
    path: StrPath, title: str, parts: Sequence[str] | str, *, whole: bool = False
) -> None:
    """Writes an HTML file of the given parts, whole or not at all."""
    content = document(title, parts, whole=whole)
    with replacing(path) as temporary:
        temporary.write_text(content, encoding="utf-8")


def document(
    title: str, parts: Sequence[str] | str, *, whole: bool = False, live: bool = False
) -> str:
    """The HTML that `write_page` writes; of a live page with what it needs besides."""
    scripts, styles = (_SCRIPTS, _STYLES) if not live else (_LIVE_SCRIPTS, _LIVE_STYLES)
    return _PAGE.format(
        title=html.escape(title),
        style="".join(map(_resource, styles)),
        kind="whole" if whole else "report",
        body="\n".join([parts] if isinstance(parts, str) else parts),
        script="".join(map(_resource, scripts)),
    )


def live_document(animation: Animation, robot: str, kind: str) -> str:
    """A live page of an arm, to "teach" or to "view" it."""
    panel = _PANEL.format(kind=kind, before=_RECORDING if kind == "teach" else "")
    title = f"Teach {robot}" if kind == "teach" else robot
    return document(title, [scene(animation), panel], whole=True, live=True)


def scene(animation: Animation, caption: str = "") -> str:
    """A scene to look at from all sides and to play, with a caption below."""
    remarks = "".join(f"<div>{html.escape(remark)}</div>" for remark in animation.remarks)
    return _SCENE.format(
        data=packed(animation, **_extent(animation)), caption=_caption(caption), remarks=remarks
    )


def figure(drawn: Figure, caption: str = "") -> str:
    """A figure as vector graphics, sharp at every size, on light and dark pages, with a caption."""
    from leadthrough.drawing.figure import svg_of  # noqa: PLC0415 (most pages have no figure)

    return f"<figure>{svg_of(drawn, caption or 'figure')}{_caption(caption)}</figure>"


def gallery(parts: Sequence[str], *, width: float = 18.0) -> str:
    """Figures side by side, as many in a row as there is room for."""
    return f'<div class="gallery" style="--least: {width:g}rem">{"".join(parts)}</div>'


def legend(entries: Mapping[str, str], *, dashed: Sequence[str] = ()) -> str:
    """The meaning of the colours of figures."""
    own = {palette.BLACK: "currentColor"}  # that of the page's text
    lines = []
    for name, colour in entries.items():
        kind = "dashed" if name in dashed else "line"
        mark = f'<i class="{kind}" style="color: {own.get(colour, colour)}"></i>'
        lines.append(f"<li>{mark}{html.escape(name)}</li>")
    return f'<ul class="legend">{"".join(lines)}</ul>'


def table(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table of rows of values below the names of its columns; it scrolls where it is too wide."""
    head = "".join(f'<th scope="col">{html.escape(name)}</th>' for name in columns)
    lines = ("".join(f"<td>{html.escape(str(value))}</td>" for value in row) for row in rows)
    body = "\n".join(f"<tr>{line}</tr>" for line in lines)
    return (
        f'<div class="wide" tabindex="0"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def terms(explained: Mapping[str, str]) -> str:
    """A list of terms, each with what it means."""
    return "<dl>{}</dl>".format(
        "".join(
            f"<dt>{html.escape(term)}</dt><dd>{html.escape(meaning)}</dd>"
            for term, meaning in explained.items()
        )
    )


def text(content: str) -> str:
    """A paragraph of text."""
    return f"<p>{html.escape(content)}</p>"


def heading(content: str) -> str:
    """The title of a section, which `contents` leads to."""
    return f'<h2 id="{_anchor(content)}">{html.escape(content)}</h2>'


def contents(headings: Sequence[str]) -> str:
    """Links to sections."""
    links = (f'<a href="#{_anchor(each)}">{html.escape(each)}</a>' for each in headings)
    return f'<nav aria-label="contents">{"".join(links)}</nav>'


def _anchor(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _caption(content: str) -> str:
    return f"<figcaption>{html.escape(content)}</figcaption>" if content else ""


def _resource(name: str) -> str:
    return (files("leadthrough.show") / name).read_text(encoding="utf-8")


def packed(animation: Animation, *, level: int = _LEVEL, **told: Any) -> str:
    """The scene as base64 of deflated bytes: the head's length, the head as JSON, arrays."""
    arrays: list[NDArray[np.generic]] = []

    def stored(values: ArrayLike, kind: type[np.generic]) -> int:
        arrays.append(np.ascontiguousarray(values, dtype=kind).ravel())
        return len(arrays) - 1

    # Both arms of a robot have the same surfaces: these are shaded and written once.
    known: dict[tuple[Surface, str], dict[str, int]] = {}
    items = []
    for item in animation.items:
        key = (item.mesh, item.layer)
        if key not in known:
            mesh, normals = item.shaded()
            known[key] = {
                "vertices": stored(_rounded(mesh.vertices), np.float32),
                "normals": stored(np.round(127.0 * normals), np.int8),
                "faces": stored(mesh.faces, np.uint32),
            }
        items.append(
            {
                "name": item.name,
                "layer": item.layer,
                "colour": [round(part, 4) for part in item.colour],
                "opacity": item.opacity,
                "link": -1 if item.link is None else item.link,
                **known[key],
            }
        )
    poses = np.concatenate([animation.positions, animation.orientations], axis=2)
    head = {
        "links": animation.links,
        "tip": animation.tip,
        "times": [round(float(time), 5) for time in animation.times],
        "poses": stored(_rounded(poses), np.float32),
        "items": items,
        "readouts": animation.readouts,
        **told,
    }
    return _deflated(head, arrays, level)


def _deflated(head: dict[str, Any], arrays: Sequence[NDArray[np.generic]], level: int) -> str:
    # Numbers of four bytes have to start at multiples of four.
    parts = [array.tobytes() + bytes(-array.nbytes % 4) for array in arrays]
    offsets = np.cumsum([0, *map(len, parts)])
    head["arrays"] = [
        {"kind": array.dtype.name, "offset": int(offset), "count": array.size}
        for array, offset in zip(arrays, offsets, strict=False)
    ]
    encoded = json.dumps(head, allow_nan=False).encode()
    encoded += b" " * (-len(encoded) % 4)
    content = b"".join([len(encoded).to_bytes(4, "little"), encoded, *parts])
    return base64.b64encode(zlib.compress(content, level)).decode()


def _rounded(values: Float64Array) -> Float64Array:
    """Rounded to 2^-18 m, 4 um: slivers of a fine mesh keep their shape, and it deflates well."""
    return np.asarray(np.round(values * 2.0**18) / 2.0**18)


def _extent(animation: Animation) -> dict[str, Any]:
    """The ball that the camera shows at first, and the height of the floor, m."""
    centre, radius = animation.ball()
    lowest = min(
        (float(i.mesh.vertices[:, 2].min()) for i in animation.items if i.link is None), default=0.0
    )
    return {
        "centre": np.round(centre, 4).tolist(),
        "radius": round(radius, 4),
        "floor": round(min(lowest, 0.0), 4),
    }


_SCENE = """<figure class="scene"><div class="stage"><canvas tabindex="0" role="img"
aria-label="3D scene: arrow keys turn it, plus and minus zoom, space plays"></canvas>
<div class="layers" role="group" aria-label="layers"></div>
<div class="trouble"></div>
<div class="foot"><div class="remarks">{remarks}</div><p class="reading"></p>
<div class="bar"><div class="curves" hidden></div>
<button class="play" aria-label="play">▶</button>
<input class="time" type="range" min="0" max="1" step="any" value="0" aria-label="time">
<span class="clock"></span>
<select class="speed" aria-label="speed"><option value="0.25">1/4 x</option>
<option value="1" selected>1 x</option><option value="2">2 x</option></select>
<select class="figure" aria-label="curves"><option value="">no curves</option></select>
<button class="home">Reset view</button></div></div></div>
<script type="text/plain">{data}</script>{caption}</figure>"""

_PANEL = """<section class="panel {kind}" aria-label="motion">{before}
<div class="sliders"></div>
<div class="buttons"><button class="turning" aria-pressed="false">Turn what is dragged</button>
<button class="undo">Undo correction</button></div>
<p class="told" role="status"></p>
<p class="next" hidden>next: <code></code></p></section>"""

_RECORDING = """<div class="buttons"><button class="record">Record</button>
<button class="gripper">Gripper</button><button class="learn">Learn</button>
<button class="save">Save</button><button class="export">Save as LeRobot</button></div>
<ol class="demonstrations"></ol>
<button class="restore" hidden>Undo last change of the list</button>"""

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
{style}</style></head>
<body class="{kind}"><main><h1>{title}</h1>
{body}
</main>
<script>
{script}</script></body></html>
"""
