"""ProMP and GMR on human handwriting, each demonstration left out once, from its start."""

import numpy as np

from leadthrough.io import lasa
from leadthrough_studies.lasa.study import compare

# Swept error areas in mm^2 that other implementations reach on the same data: ProMP 126, GMR 145.
PROMP_LIMIT = 120.0
GMR_LIMIT = 140.0
# The whole set takes a minute.
SOME = ("BendedLine", "JShape", "Sshape")


def mean_area(method, motions):
    rows = [
        row
        for motion in motions
        for row in compare(motion=motion, protocol="LOO", method=method, seed=0)
    ]
    return np.mean([row["SEA_mm2"] for row in rows])


def test_promp_predicts_left_out_handwriting_better_than_its_peers():
    assert mean_area("ProMP", lasa.motions()) < PROMP_LIMIT


def test_gmr_predicts_left_out_handwriting():
    assert mean_area("GMR", SOME) < GMR_LIMIT
