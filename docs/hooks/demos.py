"""A page of every numbered demo: its code, its picture, and a scene that plays."""

import ast
import contextlib
import io
import runpy
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest.mock import patch

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

_DEMOS = sorted((Path(__file__).parents[2] / "python" / "demos").glob("[0-9]*.py"))
_PICTURES = Path(__file__).parents[1] / "demos" / "pictures"
# Scenes that demos write, which are run whenever the pages are built, and the module that a demo
# needs; where it is missing, there is the picture alone.
_SCENES = {
    "20_view_motion": ("motion.html", "leadthrough"),
    "27_plan_motion": ("planned.html", "leadthrough"),
    "28_meshes_and_point_clouds": ("obstacles.html", "leadthrough"),
    "30_simulate_motion": ("simulated.html", "mujoco"),
    "37_blocked_paths": ("blocked.html", "leadthrough"),
}
_PLAYED = {demo: file for demo, (file, needed) in _SCENES.items() if find_spec(needed)}
# Their pictures are of the scene.
_SEEN = ("20_view_motion", "28_meshes_and_point_clouds", "30_simulate_motion")


def on_page_markdown(markdown: str, **_: Any) -> str:
    if "{{ demos }}" in markdown:
        return markdown.replace("{{ demos }}", "\n".join(_cards()))
    return markdown


def on_files(files: Files, config: MkDocsConfig) -> Files:
    for i, demo in enumerate(_DEMOS):
        around = _DEMOS[i - 1] if i else None, _DEMOS[i + 1] if i + 1 < len(_DEMOS) else None
        path = f"demos/{demo.stem}.md"
        files.append(File.generated(config, path, content="\n".join(_page(demo, *around))))
        if demo.stem in _PLAYED:
            content = _written(demo, _PLAYED[demo.stem])
            files.append(File.generated(config, f"demos/{_scene(demo)}", content=content))
    return files


def _cards() -> Iterator[str]:
    yield '<div class="cards">'
    for demo in _DEMOS:
        picture = f'<img src="pictures/{demo.stem}.webp" alt="" loading="lazy">'
        shown = picture if _has_picture(demo) else ""
        yield f'<a href="{demo.stem}.html">{shown}<span>{_number(demo)} {_title(demo)}</span></a>'
    yield "</div>"


def _page(demo: Path, before: Path | None, after: Path | None) -> Iterator[str]:
    text = demo.read_text(encoding="utf-8")
    yield f"# {_number(demo)} {_title(demo)}\n"
    if _has_picture(demo) and not (demo.stem in _PLAYED and demo.stem in _SEEN):
        yield f"![{_title(demo)}](pictures/{demo.stem}.webp)\n"
    if demo.stem in _PLAYED:
        yield f'<iframe class="scene" src="{_scene(demo)}" title="{_title(demo)}"></iframe>\n'
    yield f"Run it: `python python/demos/{demo.name} [FOLDER]`\n"
    yield f"```python\n{_code(text)}\n```\n"
    links = [
        f"[{_number(each)} {_title(each)}]({each.stem}.md)" for each in (before, after) if each
    ]
    yield " · ".join(links) + "\n"


def _scene(demo: Path) -> str:
    return f"{demo.stem}-scene.html"


def _written(demo: Path, name: str) -> str:
    """The file that a demo writes, run in this process: what all of them import is here once."""
    said = contextlib.redirect_stdout(io.StringIO())
    with tempfile.TemporaryDirectory() as folder, said, patch("sys.argv", [str(demo), folder]):
        runpy.run_path(str(demo), run_name="__main__")
        return (Path(folder) / name).read_text(encoding="utf-8")


def _number(demo: Path) -> str:
    return demo.stem.partition("_")[0]


def _title(demo: Path) -> str:
    docstring = ast.get_docstring(ast.parse(demo.read_text(encoding="utf-8"))) or ""
    return docstring.splitlines()[0].rstrip(".")


def _code(text: str) -> str:
    """The script without its docstring."""
    body = ast.parse(text).body
    return "\n".join(text.splitlines()[body[0].end_lineno or 0 :]).strip()


def _has_picture(demo: Path) -> bool:
    return (_PICTURES / f"{demo.stem}.webp").is_file()
