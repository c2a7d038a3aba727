"""Movement primitives in files and pickles: equal to the bit."""

import pickle

import pytest
from models.dmp.turns import demonstration, turn
from motions import arch, ring

import leadthrough as lt

CASES = {
    "joints": (lt.DMP(20, form="hoffmann"), lambda: arch("joints")),
    "anchored": (lt.DMP(20, orientation="anchored"), lambda: demonstration(*turn(120, 100))),
    "lifted": (lt.DMP(20, orientation="lifted"), lambda: demonstration(*turn(120, 100))),
    "log": (lt.DMP(20, orientation="log"), lambda: demonstration(*turn(120, 100))),
    "euler": (lt.DMP(20, orientation="euler"), lambda: demonstration(*turn(120, 100))),
    "lauretti": (lt.DMP.lauretti(20), lambda: demonstration(*turn(120, 100))),
    "rhythm": (lt.RhythmicDMP(), lambda: ring("points")),
    "rhythm of poses": (lt.RhythmicDMP(), lambda: ring("poses")),
}


@pytest.mark.parametrize("name", CASES)
def test_a_skill_survives_pickling_and_saving(name, tmp_path):
    model, demonstrated = CASES[name]
    skill = model.fit([demonstrated()])
    first = skill.generate()
    goal = first.positions[-1] + 0.1
    query = {"goal": goal, "duration": 4.0}
    expected = skill.generate(**query)
    skill.save(tmp_path / "skill.npz")
    for again in (pickle.loads(pickle.dumps(skill)), lt.load_skill(tmp_path / "skill.npz")):
        assert type(again) is type(skill)
        assert again.model == skill.model
        made = again.generate(**query)
        for part in ("positions", "orientations", "velocities"):
            if getattr(expected, part, None) is not None:
                assert getattr(made, part).tobytes() == getattr(expected, part).tobytes()
        assert getattr(made, "joint_names", None) == getattr(expected, "joint_names", None)
