"""What every model promises. A new one joins with one line in MODELS."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models import TaskGMR

MODELS = {
    "movement primitive": lt.DMP(),
    "movement primitive, by its force": lt.DMP(regression="ridge"),
    "fast marching": lt.FastMarching(),
    "fast marching, one map": lt.FastMarching(method="map"),
    "fast marching, by start": lt.FastMarching(method="start"),
    "ProMP": lt.ProMP(),
    "ProMP, B-splines": lt.ProMP(basis="bspline"),
    "GMR": lt.GMR(),
    "GMR, task-parameterised": TaskGMR(components=4),
}


def arch(shift=0.0, *, height=0.1, scale=1.0, events=()):
    t = np.linspace(0.0, 1.0, 150)
    u = 10 * t**3 - 15 * t**4 + 6 * t**5
    points = np.column_stack([0.3 * u, height * np.sin(np.pi * u) + shift * (1 - u)])
    return lt.Demonstration(lt.Trajectory(1.5 * t, scale * points, events))


SHOWN = [arch(shift) for shift in (-0.02, 0.0, 0.02)]


@pytest.fixture(params=MODELS, ids=str)
def model(request):
    return MODELS[request.param]


@pytest.fixture
def skill(model):
    return model.fit(SHOWN)


def test_fit_leaves_model_and_demonstrations_alone_and_returns_a_frozen_skill(model):
    before = [demonstration.motion.positions.copy() for demonstration in SHOWN]
    skill = model.fit(SHOWN)
    assert skill is not model
    for demonstration, positions in zip(SHOWN, before, strict=True):
        np.testing.assert_array_equal(demonstration.motion.positions, positions)
    with pytest.raises(AttributeError):
        skill.shown = ()


def test_generated_motion_is_of_the_type_shown_and_like_it(skill):
    motion = skill.generate()
    assert isinstance(motion, lt.Trajectory)
    middle = SHOWN[1].motion.positions
    gaps = np.linalg.norm(middle[:, None] - motion.positions[None], axis=2)
    assert gaps.min(axis=1).max() < 0.03
    assert motion.duration == pytest.approx(1.5, rel=0.1)


def test_new_start_goal_and_duration_are_met(skill):
    assert {"start", "goal", "duration"} <= skill.supports
    motion = skill.generate(start=(0.02, 0.03), goal=(0.33, -0.02), duration=4.0, dt=0.02)
    np.testing.assert_allclose(motion.positions[[0, -1]], [(0.02, 0.03), (0.33, -0.02)], atol=1e-9)
    assert motion.times[0] == 0.0
    assert motion.duration == pytest.approx(4.0)
    assert np.diff(motion.times).max() <= 0.02 + 1e-12


def test_same_query_gives_the_same_bits(model, skill):
    again = model.fit(SHOWN).generate(start=(0.01, 0.0))
    assert again.positions.tobytes() == skill.generate(start=(0.01, 0.0)).positions.tobytes()


def test_saved_skill_comes_back_with_the_same_bits(skill, tmp_path):
    path = tmp_path / "skill.npz"
    skill.save(path)
    loaded = lt.load_skill(path)
    assert type(loaded) is type(skill)
    assert loaded.generate().positions.tobytes() == skill.generate().positions.tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["skill.npz"]


def test_events_come_where_they_were_shown_to_and_are_saved(model, tmp_path):
    happened = [
        [lt.Event(0.6 + later, "closed"), lt.Event(1.5, "opened")] for later in (0.0, 0.1, 0.2)
    ]
    skill = model.fit([arch(events=each) for each in happened])
    made = skill.generate(duration=3.0, goal=(0.33, -0.02))
    assert [event.name for event in made.events] == ["closed", "opened"]
    assert made.events[0].time == pytest.approx(1.4, abs=0.06)  # the mean, in twice the time
    assert made.events[1].time == pytest.approx(3.0, abs=0.06)
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").generate().events == skill.generate().events


def test_one_demonstration_is_enough(model):
    motion = model.fit(SHOWN[:1]).generate()
    np.testing.assert_allclose(motion.positions[-1], (0.3, 0.0), atol=1e-9)


def test_scale_of_the_data_does_not_matter(model):
    metres = model.fit(SHOWN).generate()
    millimetres = model.fit([arch(s, scale=1000.0) for s in (-0.02, 0.0, 0.02)]).generate()
    np.testing.assert_allclose(millimetres.positions, 1000 * metres.positions, atol=1e-2)


@pytest.mark.parametrize(
    "query",
    [
        {"start": (0.0, np.nan)},
        {"goal": (0.0,)},
        {"duration": -1.0},
        {"dt": 0.0},
        {"start": "here"},
    ],
)
def test_bad_query_is_refused_by_name(skill, query):
    with pytest.raises(InvalidInput, match=next(iter(query))):
        skill.generate(**query)


def test_bad_demonstrations_are_refused(model):
    still = lt.Demonstration(lt.Trajectory([0.0, 1.0], [[1.0, 1.0], [1.0, 1.0]]))
    single = lt.Demonstration(lt.Trajectory([0.0], [[1.0, 1.0]]))
    for shown in ([still], [single]):
        with pytest.raises(FitError):
            model.fit(shown)
    for shown in ([None], SHOWN[0], 3):
        with pytest.raises(InvalidInput):
            model.fit(shown)
