"""What the README and the demo scripts promise, as they stand."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DEMOS = sorted((ROOT / "python" / "demos").glob("*.py"))


def run_python(arguments, folder):
    return subprocess.run(
        [sys.executable, "-W", "error", *arguments],
        cwd=folder,
        env=os.environ | {"MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_example_of_the_readme_runs_and_writes_a_trajectory(tmp_path):
    (example,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    result = run_python(["-c", example], tmp_path)
    assert result.returncode == 0, result.stderr
    message = json.loads((tmp_path / "gshape.json").read_text())
    assert len(message["joint_names"]) == 6
    assert len(message["points"]) > 100


def test_readme_names_every_demo():
    text = (ROOT / "README.md").read_text()
    assert DEMOS
    for demo in DEMOS:
        assert f"python/demos/{demo.name}" in text


@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_demo_is_short_and_leaves_what_it_announces(demo, tmp_path):
    assert len(demo.read_text().splitlines()) < 60
    result = run_python([str(demo), str(tmp_path)], tmp_path)
    assert result.returncode == 0, result.stderr
    announced = re.findall(r"\S+\.(?:png|json|html)", result.stdout.split("wrote", 1)[1])
    assert announced
    for name in announced:
        assert Path(name).stat().st_size > 1000
