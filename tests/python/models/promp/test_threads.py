"""A ProMP is the same, bit by bit, whatever the number of threads of the linear algebra."""

import json
import os
import subprocess
import sys

BEFORE = "import hashlib, numpy as np, leadthrough as lt\n"
AFTER = 'print(hashlib.sha256(b"".join(np.asarray(a).tobytes() for a in arrays)).hexdigest())'

FITTED = """
u = np.linspace(0.0, 1.0, 150)
shown = []
for i in range(9):
    turned = lt.rotations.exp(np.column_stack([2.5 * u, 0.3 * np.sin(4.0 * u), 0.1 * i * u]))
    sway = 0.1 * np.sin(2.0 * u + 0.05 * i)
    points = np.column_stack([0.2 * u, sway, 0.01 * i * np.sin(3.0 * u)])
    shown.append(lt.PoseTrajectory(2.0 * u, points, turned))
skill = lt.ProMP(weights=WEIGHTS, estimator="ESTIMATOR").fit(shown)
made = skill.generate(start=(shown[0].positions[0] + 0.01, shown[0].orientations[0]))
passing = skill.condition(1.0, (shown[1].positions[75], shown[1].orientations[75]))
arrays = [skill.weights.mean, skill.weights.covariance, made.positions, made.orientations]
arrays += [skill.noise, passing.weights.mean, passing.weights.covariance]
arrays += skill.distribution(np.linspace(0.0, 2.0, 40))
for drawn in skill.sample(3, seed=1):
    arrays += [drawn.positions, drawn.orientations]
arrays += [np.array(skill.log_likelihood(shown[1]))]
"""


WITHIN = """

u = np.linspace(0.0, 1.0, 100)
shown = []
for i in range(9):
    columns = [np.sin((1 + 0.2 * j) * u) + 0.01 * i * np.sin((3 + j % 4) * u + i) for j in range(7)]
    shown.append(lt.JointTrajectory(u, np.column_stack(columns), joint_names=tuple("abcdefg")))
all_of = np.concatenate([each.positions for each in shown])
skill = lt.ProMP(weights=20).fit(shown)
limited = skill.within(all_of.min(axis=0) + 0.02, all_of.max(axis=0) - 0.02)
arrays = [limited.generate().positions, *limited.distribution(np.linspace(0.0, 1.0, 40))]
arrays += [drawn.positions for drawn in limited.sample(3, seed=1)]
"""

INFERRED = """

u = np.linspace(0.0, 1.0, 100)
rng = np.random.default_rng(0)
shown = []
for i in range(12):
    waves = [np.sin((1 + 0.2 * j) * u + 0.1 * rng.normal()) for j in range(7)]
    shown.append(lt.JointTrajectory(2 * u, np.column_stack(waves), joint_names=tuple("abcdefg")))
skill = lt.ProMP(weights=35).fit(shown[1:])
found = lt.models.infer(shown[0][:40], [skill])
arrays = [found.durations, found.skills[0].weights.mean, found.skills[0].weights.covariance]
"""


CODES = {
    f"poses, {weights} weights, {estimator}": FITTED.replace("WEIGHTS", str(weights)).replace(
        "ESTIMATOR", estimator
    )
    for weights in (20, 35)
    for estimator in ("least_squares", "em")
} | {"within": WITHIN, "infer": INFERRED}


def digests(threads):
    """Output of each of the programs, all run in one process with so many threads."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    run = "import json, sys\nfor code in json.load(sys.stdin):\n    exec(code, {})"
    environment = {**os.environ, **dict.fromkeys(names, str(threads))}
    codes = json.dumps([f"{BEFORE}{code}\n{AFTER}" for code in CODES.values()])
    words = [sys.executable, "-c", run]
    printed = subprocess.run(
        words, input=codes, env=environment, capture_output=True, text=True, check=True
    ).stdout
    return dict(zip(CODES, printed.split(), strict=True))


def test_all_is_fitted_drawn_and_inferred_to_the_same_bits_with_one_thread_and_two():
    one, two = digests(1), digests(2)
    assert {len(digest) for digest in one.values()} == {64}
    assert len(set(one.values())) == len(CODES)
    assert one == two
