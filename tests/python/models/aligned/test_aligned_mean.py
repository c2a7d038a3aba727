"""The mean of aligned demonstrations, and the choice among families."""

import motions
import numpy as np
import pytest
from refusals import refused
from scipy.interpolate import PchipInterpolator
from scipy.spatial import cKDTree, procrustes

import leadthrough as lt
from leadthrough.errors import FitError, NoPath
from leadthrough.preprocess import by_arc_length, frechet_distance

TIMES = np.linspace(0.0, 2.0, 201)
U = TIMES / 2.0


def stroke(start=(0.0, 0.0), goal=(1.0, 0.0), height=0.3, fade=None):
    """A hump whose start's offset fades by a law of the phase, linearly by default."""
    left = (1.0 - U) if fade is None else fade
    path = np.column_stack([U, height * np.sin(np.pi * U)])
    path = path + left[:, None] * np.asarray(start)
    return lt.Trajectory(TIMES, path + U[:, None] * (np.asarray(goal) - (1.0, 0.0)))


def apart(a, b):
    return frechet_distance(by_arc_length(a.positions, 200), by_arc_length(b.positions, 200))


def ten_minutes(seed):
    """A tip led to and fro for ten minutes, with a tremor, by places and a timing of its own."""
    own, common = np.random.default_rng(seed), np.random.default_rng(0)
    spans = common.uniform(2.0, 6.0, 150) + own.normal(0.0, 0.05, 150)
    places = common.uniform(-0.3, 0.3, (151, 3)) + own.normal(0.0, 1e-3, (151, 3))
    knots = np.concatenate([[0.0], np.cumsum(spans)])
    times = np.linspace(0.0, knots[-1], 150_000)
    path = PchipInterpolator(knots, places)(times)
    return lt.Trajectory(times, path + 1e-4 * np.sin(50.0 * times + seed)[:, None])


def test_logs_of_ten_minutes_are_reproduced_within_millimetres():
    """Too few rows kept their corners, and too few points told the distance of paths so long."""
    one, other = ten_minutes(1), ten_minutes(2)
    skill = lt.AlignedMean().fit([one])
    assert lt.models.reproduction(skill, [one]).position < 2e-3
    made = skill.generate(start=one.positions[0], goal=one.positions[-1])
    assert cKDTree(made.positions).query(one.positions[::10])[0].max() < 2e-3
    both = lt.models.reproduction(lt.AlignedMean().fit([one, other]), [one, other])
    assert both.position < 6e-3


def test_one_demonstration_is_reproduced():
    shown = stroke()
    made = lt.AlignedMean().fit([shown]).generate()
    assert apart(shown, made) < 2e-3
    assert made.duration == pytest.approx(2.0)


@pytest.mark.parametrize("apart", (0.0, 1e-16, 1e-12, 1e-6))
def test_ends_that_are_the_same_up_to_rounding_fade_no_rounding(apart):
    starts = [(0.0, y * apart) for y in (-1.0, 0.3, 1.0)]
    shown = [stroke(each, height=h) for each, h in zip(starts, (0.27, 0.3, 0.33), strict=True)]
    skill = lt.AlignedMean().fit(shown)
    assert frechet_distance(skill.generate().positions, stroke().positions) < 5e-3
    moved = skill.generate(start=(0.0, 0.01), goal=(1.02, 0.0)).positions
    assert frechet_distance(moved, stroke((0.0, 0.01), (1.02, 0.0)).positions) < 0.02


def test_where_the_start_is_forgotten_is_learned():
    forgotten = np.clip(1.0 - U / 0.3, 0.0, 1.0)  # the hand joins the common path at 30 %
    starts = [(0.0, y) for y in np.linspace(-0.2, 0.2, 9)]
    skill = lt.AlignedMean().fit([stroke(start, fade=forgotten) for start in starts])
    wanted = stroke((0.0, 0.12), fade=forgotten)
    made = skill.generate(start=(0.0, 0.12), goal=(1.0, 0.0))
    assert apart(made, wanted) < 0.01
    assert apart(stroke((0.0, 0.12)), wanted) > 0.05  # of a linear fade


def test_a_start_that_was_amplified_moves_the_path_by_no_more_than_its_offset():
    """The demonstrations' middles are off by six times as much as their starts."""
    swell = 1.0 - U + 5.5 * np.sin(np.pi * U)
    shown = [stroke((0.0, y), fade=swell) for y in np.linspace(-0.1, 0.1, 7)]
    skill = lt.AlignedMean().fit(shown)
    plain, made = skill.generate(), skill.generate(start=(0.0, 0.2))
    assert apart(plain, made) <= 1.5 * 0.2


def test_far_goals_keep_half_of_the_shape_that_a_linear_fade_loses():
    skill = lt.AlignedMean().fit([stroke((0.0, y)) for y in (-0.02, 0.0, 0.03)])
    nominal = by_arc_length(skill.generate().positions, 200)

    def lost(path):
        return procrustes(nominal, by_arc_length(path, 200))[2]

    for x, y in ((1.0, 1.0), (0.3, -0.8), (1.9, -0.5)):
        goal = np.array([x, y])
        fade = nominal + np.linspace(0.0, 1.0, 200)[:, None] * (goal - nominal[-1])
        assert lost(skill.generate(goal=goal).positions) < 0.5 * lost(fade)


def test_the_tremor_of_the_hand_is_not_replayed():
    rng = np.random.default_rng(4)
    phases = 2.0 * np.pi * (25.0 * U[:, None] + rng.random((5, 1, 2)))
    shown = [lt.Trajectory(TIMES, stroke().positions + 1e-3 * np.sin(each)) for each in phases]
    bends = [
        np.abs(np.diff(lt.AlignedMean().fit(each).generate().positions, 2, axis=0)).max()
        for each in ([stroke()], shown)
    ]
    assert bends[1] < 2.0 * bends[0]


def test_what_was_learned_is_read_only():
    skill = lt.AlignedMean().fit([stroke(), stroke((0.0, 0.1))])
    curves = skill.predictor.phased
    for array in (skill.scale, skill.ends, *(a for c in curves for a in (c.rows, c.times))):
        assert not array.flags.writeable


def test_a_pose_that_turns_on_the_spot_needs_no_detour_and_none_exists_inside_an_obstacle():
    q = lt.rotations.exp(np.outer(U, [0.0, 0.0, 1.0]))
    here = np.tile([0.4, 0.0, 0.3], (len(U), 1))
    skill = lt.AlignedMean().fit([lt.PoseTrajectory(TIMES, here, q)])
    beside = skill.generate(obstacles=[lt.Sphere(0.05, (0.5, 0.0, 0.3))])
    np.testing.assert_allclose(beside.positions, here[:1].repeat(len(beside), 0), atol=1e-9)
    with pytest.raises(NoPath, match="lies in an obstacle"):
        skill.generate(obstacles=[lt.Sphere(0.05, (0.4, 0.0, 0.3))])


def test_two_ways_are_told_apart():
    heights = (0.4, 0.42, 0.38, -0.4, -0.42, -0.38)
    starts = [(0.0, 0.02 * np.sign(height)) for height in heights]
    shown = [stroke(s, height=h) for s, h in zip(starts, heights, strict=True)]
    skill = lt.AlignedMean().fit(shown)
    assert [len(each.ends) for each in skill.modes] == [3, 3]
    for side in (1.0, -1.0):
        made = skill.generate(start=(0.0, 0.02 * side), goal=(1.0, 0.0))
        alone = lt.AlignedMean().fit(
            [m for m, h in zip(shown, heights, strict=True) if h * side > 0]
        )
        assert apart(made, alone.generate(start=(0.0, 0.02 * side), goal=(1.0, 0.0))) < 1e-9


def test_pauses_change_the_timing_and_not_the_shape():
    shown = [stroke(height=height) for height in (0.28, 0.3, 0.33)]
    paused = []
    for i, each in enumerate(shown):
        row = 60 + 40 * i
        rows = np.insert(each.positions, [row] * 100, each.positions[row], axis=0)
        paused.append(lt.Trajectory(np.arange(len(rows)) * 0.01, rows))
    plain, delayed = (lt.AlignedMean().fit(each).generate() for each in (shown, paused))
    assert apart(plain, delayed) < 2e-3
    assert delayed.duration == pytest.approx(plain.duration + 1.0, abs=0.01)


@pytest.mark.parametrize("count", (1, 3))
def test_a_log_of_minutes_rests_where_the_hand_did(count):
    """Speeds were averaged over a fraction of the log: rests of a second were passed at speed."""
    times = np.arange(0.0, 280.0, 0.02)
    rest = times % 14.0 > 13.0
    phase = np.minimum(times % 14.0 / 13.0, 1.0)
    places = np.random.default_rng(0).uniform(-0.3, 0.3, (21, 3))
    at = (times / 14.0).astype(int)
    path = places[at] + motions.minimum_jerk(phase)[:, None] * np.diff(places, axis=0)[at]
    shown = [
        lt.Trajectory(times * (1.0 + 0.05 * i), path + 1e-4 * np.sin(30.0 * times + i)[:, None])
        for i in range(count)
    ]
    made = lt.AlignedMean().fit(shown).generate(duration=280.0)
    speed = np.linalg.norm(np.gradient(made.positions, made.times, axis=0), axis=1)
    there = np.interp(made.times, times, rest) == 1.0
    assert speed[there].max() < 0.1 * speed.mean()


def test_a_pose_reaches_orientations_far_from_the_goal_s():
    shown = [motions.arch("poses", shift) for shift in (-0.02, 0.0, 0.02)]
    made = lt.AlignedMean().fit(shown).generate()
    gap = lt.rotations.distance(made.orientations[[0, -1]], shown[1].orientations[[0, -1]])
    assert gap.max() < 0.02


def test_the_family_that_predicts_left_out_demonstrations_is_learned(tmp_path):
    shown = [stroke((0.0, y), height=0.3 + y) for y in (-0.1, -0.05, 0.0, 0.05, 0.1)]
    skill = lt.learn(shown, candidates=["dmp", "aligned-mean"])
    assert skill.choice.chosen == min(skill.choice.errors, key=skill.choice.errors.get)
    assert isinstance(skill, type(lt.AlignedMean().fit(shown)))
    skill.save(tmp_path / "skill.npz")
    assert str(lt.load_skill(tmp_path / "skill.npz").choice) == str(skill.choice)
    assert lt.AlignedMean().fit(shown).choice is None


def test_the_first_family_stays_unless_another_is_twice_as_near():
    shown = [stroke((0.0, y), height=0.3 + y) for y in (-0.1, -0.05, 0.0, 0.05, 0.1)]
    skill = lt.learn(shown, candidates=["gmr", "fast-marching"])
    first, second = skill.choice.errors.values()
    assert 0.5 * first < second < 0.75 * first
    assert skill.choice.chosen == "gmr"
    assert "gmr: no other is twice as near to 5 left-out" in str(skill.choice)
    assert lt.learn(shown, candidates=["gmr", "promp"]).choice.chosen == "promp"


@pytest.mark.parametrize("share", (-1.0, 0.0, np.nan, np.inf))
def test_a_file_with_shares_that_are_none_is_refused(tmp_path, share):
    lt.AlignedMean().fit([stroke((0.0, y)) for y in (-0.1, 0.0, 0.1)]).save(tmp_path / "skill.npz")
    arrays = dict(np.load(tmp_path / "skill.npz"))
    arrays["options"][0, -1] = share
    np.savez(tmp_path / "skill.npz", **arrays)
    refused("damaged|shares", lt.load_skill, tmp_path / "skill.npz")


@pytest.mark.parametrize("turn", [6.5, 12.0])
def test_families_are_compared_beyond_whole_turns_about_an_axis_that_trembles(turn):
    rng, u = np.random.default_rng(0), np.linspace(0.0, 1.0, 150)
    way = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    shown = [
        lt.PoseTrajectory(
            3.0 * u,
            np.outer(way, [0.1, 0.05, -0.02]) + rng.normal(0.0, 0.002, 3),
            lt.rotations.exp(np.outer(turn * way, [0.1, 0.2, 0.97]) + rng.normal(0.0, 0.01, 3)),
        )
        for _ in range(3)
    ]
    skill = lt.learn(shown, candidates=["dmp", "promp"])
    assert np.isfinite(list(skill.choice.errors.values())).all()


def test_a_model_with_settings_is_a_candidate():
    shown = [stroke((0.0, y)) for y in (-0.1, 0.0, 0.1)]
    skill = lt.learn(shown, candidates=[lt.ProMP(weights=12), "dmp"])
    assert set(skill.choice.errors) == {repr(lt.ProMP(weights=12)), "dmp"}


def test_a_single_demonstration_takes_the_first_candidate():
    skill = lt.learn([stroke()])
    assert skill.choice.chosen == "aligned-mean"
    assert "cannot be left out" in str(skill.choice)


def test_families_of_other_motions_are_no_candidates():
    shown = [motions.arch("joints", shift) for shift in (-0.02, 0.0, 0.02)]
    assert "fast-marching" not in lt.learn(shown).choice.errors
    refused("candidates", lt.learn, shown, candidates=["fast-marching"])


def test_learning_from_nothing_is_refused():
    with pytest.raises(FitError, match="demonstrations"):
        lt.learn([])


@pytest.mark.parametrize("model", [lt.AlignedMean(), lt.FastMarching()], ids=str)
def test_a_detour_rejoins_the_stroke_where_it_left_it(model):
    down_and_up = np.column_stack([0.1 * np.sin(np.pi * U), 1.0 - np.abs(2.0 * U - 1.0)])
    post = lt.Sphere(0.03, (0.05, 0.5, 0.0))  # between both halves, and near both
    skill = model.fit(
        [lt.Trajectory(TIMES, down_and_up + np.array([0.0, 0.01 * i])) for i in range(3)]
    )
    plain, made = skill.generate(), skill.generate(obstacles=[post])
    assert post.distance(np.column_stack([made.positions, np.zeros(len(made))])).min() > 0.0
    lengths = [np.linalg.norm(np.diff(m.positions, axis=0), axis=1).sum() for m in (plain, made)]
    assert lengths[1] > 0.97 * lengths[0]


def test_a_mode_is_taken_by_its_number_or_because_it_is_free():
    shown = [
        stroke((0.0, 0.02 * side), height=side * h) for side in (1, -1) for h in (0.38, 0.4, 0.42)
    ]
    skill = lt.AlignedMean().fit(shown)
    ends = {"start": (0.0, 0.02), "goal": (1.0, 0.0)}
    assert skill.generate(**ends).positions[:, 1].max() > 0.3
    assert skill.generate(**ends, mode=1).positions[:, 1].min() < -0.3
    blocked = lt.Box((0.1, 0.5, 0.5), (0.5, 0.4, 0.0))
    assert skill.generate(**ends, obstacles=[blocked]).positions[:, 1].min() < -0.3
    refused("mode", skill.generate, mode=2)


def test_parts_between_the_ends_follow_these_in_other_directions():
    def bent(y):  # as high in its middle as it starts aside
        return np.column_stack([U, y * (1.0 - U), y * np.sin(np.pi * U)])

    shown = [lt.Trajectory(TIMES, bent(y)) for y in (-0.2, -0.12, -0.04, 0.06, 0.14, 0.2)]
    for y in (-0.16, 0.1):
        made = lt.AlignedMean().fit(shown).generate(start=(0.0, y, 0.0), goal=(1.0, 0.0, 0.0))
        truth = by_arc_length(bent(y), 100)
        apart = np.linalg.norm(by_arc_length(made.positions, 100) - truth, axis=1)
        assert apart.max() < 0.1 * abs(y)
