"""README and the demo scripts, run as they stand."""

import contextlib
import io
import json
import multiprocessing
import os
import re
import runpy
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "docs" / "demos" / "pictures"
ALIKE = 4.0  # of 255, mean difference of two pictures that show the same
DEMOS = sorted((ROOT / "python" / "demos").glob("[0-9]*.py"))

# Each script runs in a process of its own, forked from one that has imported what others wrote:
# nothing of leadthrough is there before the script imports it.
PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(
    ["pytest", "numpy", "scipy.interpolate", "scipy.optimize", "scipy.signal", "matplotlib.pyplot"]
)


def run_here(script, folder):
    """Output of a script, run like `python -W error SCRIPT FOLDER` in the folder."""
    os.environ["MPLBACKEND"] = "agg"
    os.chdir(folder)
    sys.argv = [str(script), str(folder)]
    sys.path.insert(0, str(script.parent))
    warnings.simplefilter("error")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        runpy.run_path(str(script), run_name="__main__")
    return printed.getvalue()


def run_script(script, folder):
    with ProcessPoolExecutor(1, mp_context=PROCESSES) as process:
        return process.submit(run_here, script, folder).result(timeout=120)


def test_example_of_the_readme_runs_and_writes_a_trajectory(tmp_path):
    (example,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    (tmp_path / "example.py").write_text(example)
    run_script(tmp_path / "example.py", tmp_path)
    message = json.loads((tmp_path / "gshape.json").read_text())
    assert len(message["joint_names"]) == 6
    assert len(message["points"]) > 100


def test_the_page_of_features_names_every_demo():
    text = (ROOT / "docs" / "features.md").read_text()
    assert DEMOS
    for demo in DEMOS:
        assert f"python/demos/{demo.name}" in text


def test_readme_is_read_in_a_minute_and_its_figures_are_those_of_the_page_on_speed():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 150
    figures = lines[lines.index("| problem | peer | times faster |") + 2 :][:6]
    assert set(figures) <= set((ROOT / "docs" / "speed.md").read_text().splitlines())


@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_demo_is_short_and_writes_the_files_that_it_announces(demo, tmp_path):
    assert len(demo.read_text().splitlines()) < 60
    printed = run_script(demo, tmp_path)
    announced = re.findall(r"\S+\.(?:png|json|html)", printed.split("wrote", 1)[1])
    assert announced
    for name in announced:
        assert Path(name).stat().st_size > 1000
    for drawn in sorted(tmp_path.glob("*.png"))[:1]:
        apart = np.abs(small(drawn) - small(PICTURES / f"{demo.stem}.webp"))
        assert np.mean(apart) < ALIKE, "run python python/pictures/demos.py docs/demos/pictures"


def small(picture):
    """The brightness of a picture, so coarse that another font counts little."""
    return np.asarray(Image.open(picture).convert("L").resize((48, 32)), float)
