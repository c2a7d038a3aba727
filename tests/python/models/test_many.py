import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models import generate_all

TIMES = np.linspace(0.0, 2.0, 40)
RISE = lt.trajectories.minimum_jerk_rise(TIMES / 2.0)[:, None]
SHOWN = [lt.Trajectory(TIMES, RISE * [0.3, 0.2 + 0.02 * k]) for k in range(3)]
QUERIES = [{"goal": (0.3 + 0.01 * k, 0.2), "dt": 0.02} for k in range(11)]


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_many_motions_are_those_of_each_query_on_any_number_of_threads(threads):
    skill = lt.DMP(weights=10).fit(SHOWN)
    motions = generate_all(skill, QUERIES, threads=threads)
    for motion, query in zip(motions, QUERIES, strict=True):
        assert motion.positions.tobytes() == skill.generate(**query).positions.tobytes()


def test_samples_are_the_same_on_any_number_of_threads():
    skill = lt.ProMP(weights=6).fit(SHOWN)
    one, three = (skill.sample(9, seed=4, threads=threads) for threads in (1, 3))
    assert [m.positions.tobytes() for m in one] == [m.positions.tobytes() for m in three]


def test_the_first_query_without_an_answer_says_why():
    skill = lt.DMP(weights=10).fit(SHOWN)
    with pytest.raises(InvalidInput, match="goal"):
        generate_all(skill, [*QUERIES, {"goal": (1.0, 2.0, 3.0)}], threads=2)
    with pytest.raises(InvalidInput, match=r"queries\[1\]: expected the arguments of generate"):
        generate_all(skill, [{}, (0.3, 0.2)])
    with pytest.raises(InvalidInput, match="threads"):
        generate_all(skill, QUERIES, threads=0)
    assert generate_all(skill, [], threads=2) == []
