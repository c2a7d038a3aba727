import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models import generate_all
from leadthrough.models.promp import basis
from leadthrough.models.promp.gaussian import Gaussian

TIMES = np.linspace(0.0, 2.0, 40)
RISE = lt.trajectories.minimum_jerk_time_scaling(TIMES / 2.0)[:, None]
SHOWN = [lt.Trajectory(TIMES, RISE * [0.3, 0.2 + 0.02 * k]) for k in range(3)]
JOINTS = lt.JointTrajectory(TIMES, np.hstack([RISE, 2.0 * RISE]), joint_names=("a", "b"))
EVENTS = [lt.Event(1.0, "grasp")]
DRAWN = [
    [lt.Trajectory(m.times, m.positions, EVENTS, JOINTS) for m in SHOWN],
    [lt.JointTrajectory(m.times, m.positions, joint_names=("a", "b")) for m in SHOWN],
    [
        lt.PoseTrajectory(
            m.times, m.positions @ np.eye(2, 3), lt.rotations.exp(m.positions @ np.ones((2, 3)))
        )
        for m in SHOWN
    ],
]
QUERIES = [{"goal": (0.3 + 0.01 * k, 0.2), "dt": 0.02} for k in range(11)]


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_many_motions_are_those_of_each_query_on_any_number_of_threads(threads):
    skill = lt.DMP(weights=10).fit(SHOWN)
    motions = generate_all(skill, QUERIES, threads=threads)
    for motion, query in zip(motions, QUERIES, strict=True):
        assert motion.positions.tobytes() == skill.generate(**query).positions.tobytes()


@pytest.mark.parametrize("shown", DRAWN, ids=["points", "joints", "poses"])
def test_samples_are_the_motions_of_their_weights_on_any_number_of_threads(shown, monkeypatch):
    monkeypatch.setattr(basis, "_BLOCK", 8 * 2000)  # bytes: some motions lie together, not all
    skill, count, dt = lt.ProMP(weights=6).fit(shown), 9, 0.01
    weights = skill.sample_weights(count, seed=4)
    alone = [skill.with_weights(Gaussian(each, skill.free.covariance)) for each in weights]
    samples = [skill.sample(count, seed=4, dt=dt, threads=threads) for threads in (1, 3)]
    for own, one, three in zip(alone, *samples, strict=True):
        expected = own.generate(dt=dt)
        assert one.events == three.events == expected.events
        for name, rows in _arrays(expected).items():
            found, threaded = _arrays(one)[name], _arrays(three)[name]
            assert found.tobytes() == threaded.tobytes(), name
            np.testing.assert_allclose(found, rows, rtol=0.0, atol=1e-13 * np.abs(rows).max())
            assert not found.flags.writeable, name


def _arrays(motion):
    beside = getattr(motion, "joints", None)
    own = {name: each for name, each in vars(motion).items() if isinstance(each, np.ndarray)}
    return own if beside is None else {**own, "joints": beside.positions}


def test_the_first_query_without_an_answer_says_why():
    skill = lt.DMP(weights=10).fit(SHOWN)
    refused("goal", generate_all, skill, [*QUERIES, {"goal": (1.0, 2.0, 3.0)}], threads=2)
    with pytest.raises(InvalidInput, match=r"queries\[1\]: expected the arguments of generate"):
        generate_all(skill, [{}, (0.3, 0.2)])
    refused("threads", generate_all, skill, QUERIES, threads=0)
    assert generate_all(skill, [], threads=2) == []
