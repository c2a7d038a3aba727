"""Pages of the notebooks: run when the pages are built, with what their cells show."""

import ast
import html
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

NOTEBOOKS = sorted((Path(__file__).parents[2] / "python" / "notebooks").glob("*.ipynb"))


def on_files(files: "Files", config: "MkDocsConfig") -> "Files":
    from mkdocs.structure.files import File

    for notebook in NOTEBOOKS:
        content = "\n".join(shown(notebook))
        files.append(File.generated(config, f"notebooks/{notebook.stem}.md", content=content))
    return files


def shown(notebook: Path) -> Iterator[str]:
    """The cells as Markdown, and after each its result."""
    names: dict[str, Any] = {}
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            yield text + "\n"
            continue
        yield f"```python\n{text}\n```\n"
        yield _drawn(_result(text, names)) + "\n"


def _result(code: str, names: dict[str, Any]) -> Any:
    """The value of a cell's last line, if it is an expression."""
    tree = ast.parse(code)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is None:
        return None
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # type: ignore[attr-defined]


def _drawn(value: Any) -> str:
    if value is None:
        return ""
    if hasattr(value, "_repr_html_"):
        inside = value._repr_html_().replace("\n", "&#10;")
        return f'<div class="result">{inside}</div>'
    return f'<pre class="result">{html.escape(repr(value))}</pre>'
