"""Scenes and browsers for the tests of what is shown."""

import shutil

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt

DOWN = (0.0, 1.0, 0.0, 0.0)
FLAGS = [
    "--no-sandbox", "--no-first-run", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--ignore-gpu-blocklist",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
]  # fmt: skip


def places_at(scene, time):
    """Positions (links, 3) of a scene's links, held beyond the ends as the page does."""
    columns = scene.positions.reshape(len(scene.times), -1).T
    return np.array([np.interp(time, scene.times, each) for each in columns]).reshape(-1, 3)


@pytest.fixture(scope="session")
def joints(panda):
    """A second in which all joints of the Panda turn by a little."""
    times = np.linspace(0.0, 1.0, 30)
    q = np.outer(times, 0.3 * np.ones(7)) + np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    return lt.JointTrajectory(times, q, joint_names=panda.joint_names)


@pytest.fixture(scope="session")
def shown():
    """Five hands carry something over a table, from its right to its left."""
    rng = np.random.default_rng(1)
    times = np.linspace(0.0, 4.0, 200)
    share = minimum_jerk(times / 4)
    demonstrations = []
    for _ in range(5):
        first, last = np.array([[0.40, -0.38, 0.18], [0.50, 0.36, 0.22]]) + rng.normal(
            0, 0.01, (2, 3)
        )
        path = first + np.outer(share, last - first)
        path[:, 2] += rng.normal(0.25, 0.03) * np.sin(np.pi * share) ** 2
        poses = lt.PoseTrajectory(times, path, np.tile(DOWN, (len(times), 1)))
        demonstrations.append(lt.Demonstration(poses))
    return demonstrations


@pytest.fixture(scope="session")
def browser():
    """A headless Chromium that draws WebGL in software."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("no chromium; ./do test installs it")
    with sync_api.sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield running
        running.close()
