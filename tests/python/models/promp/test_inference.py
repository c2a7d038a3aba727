"""Motions recognised from their beginning, and forecasts of how they go on."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.stats import chi2, multivariate_normal

import leadthrough as lt
from leadthrough.models import infer
from leadthrough.motion import lerp, normalised_times
from leadthrough_studies.comparison.recordings import read


def test_beginning_of_a_motion_tells_which_how_fast_and_how_it_goes_on(skills, family):
    whole = family(-0.12, count=1, seed=9, duration=2.6)[0]
    found = infer(whole[:60], skills)
    assert found.best == 1
    assert found.probabilities[1] > 0.99
    assert found.durations[1] == pytest.approx(2.6, rel=0.1)
    assert found.phases[1] == pytest.approx(60 / 150, rel=0.1)
    ahead, _ = found.skills[1].distribution(np.minimum(whole.times, found.durations[1]))
    assert np.abs(ahead - whole.positions).max() < 0.04
    before, _ = skills[1].distribution(np.minimum(whole.times, 2.0))
    assert np.abs(ahead - whole.positions).max() < np.abs(before - whole.positions).max()


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_probabilities_are_about_those_of_the_families_that_motions_are_drawn_from(noise, family):
    """Two families that overlap: by Bayes' rule on a motion's height, nothing else tells them."""
    heights, spread = (0.10, 0.13), 0.02

    def noisy(height, seed, count):
        rng = np.random.default_rng(seed)
        shown = family(height, seed=seed, count=count, spread=spread)
        return [
            replace(each, positions=each.positions + noise * rng.standard_normal((150, 2)))
            for each in shown
        ]

    model = lt.ProMP(weights=10)
    skills = [model.fit(noisy(h, s, 40)) for h, s in zip(heights, (1, 2), strict=True)]
    losses, gaps = [], []
    for own, height in enumerate(heights):
        for each in noisy(height, 50 + own, 12):
            found = infer(each[:75], skills).probabilities
            peak = each.positions[:, 1].max()
            likely = np.exp(-((peak - np.array(heights)) ** 2) / (2 * spread**2))
            gaps.append(found[0] - likely[0] / likely.sum())
            losses.append((np.log(found[own]), np.log(likely[own] / likely.sum())))
    ours, exact = -np.mean(losses, axis=0)
    assert ours < exact + 0.3
    assert np.sqrt(np.mean(np.square(gaps))) < 0.3


def test_a_beginning_is_forecast_along_the_way_that_it_takes(family):
    skill = lt.ProMP(weights=10).fit(family(-0.3, count=4) + family(0.3, count=4))
    assert len(skill.modes) == 2
    for height in (-0.3, 0.3):
        whole = family(height, count=1, seed=9)[0]
        (ahead,) = infer(whole[:40], [skill]).skills
        found, _ = ahead.distribution([0.5 * ahead.duration])
        assert found[0, 1] == pytest.approx(height, abs=0.1)


def test_columns_that_repeat_others_say_no_more_of_the_duration():
    rng, u = np.random.default_rng(0), np.linspace(0.0, 1.0, 101)

    def performed():
        at, times = u + 0.3 * rng.normal() * u * (1.0 - u), 2.0 * np.exp(0.2 * rng.normal()) * u
        rise = 0.5 * at + 0.05 * rng.normal() * np.sin(np.pi * at)
        return times, np.stack([rise, 0.1 * np.sin(2.0 * np.pi * at) + 0.1 * rng.normal() * at], 1)

    motions = [performed() for _ in range(8)]
    for i in (2, 5):  # the shortest and the longest
        once, thrice = (
            [lt.Trajectory(times, np.tile(path, copies)) for times, path in motions]
            for copies in (1, 3)
        )
        found = [
            infer(own[i][:45], [lt.ProMP().fit(own[:i] + own[i + 1 :])]).durations[0]
            for own in (once, thrice)
        ]
        assert found[0] == pytest.approx(found[1], rel=0.08)


def test_prior_counts(skills, family):
    seen = family(0.1, count=1, seed=9)[0][:3]
    assert infer(seen, skills, prior=[0.0, 1.0]).best == 1
    refused("prior", infer, seen, skills, prior=[0.0, 0.0])
    refused("observed", infer, lt.Trajectory([0.0], [[0.0, 0.0]]), skills)


def test_skills_of_other_joints_are_refused(skill, shown):
    renamed = [lt.JointTrajectory(each.times, each.positions) for each in shown()]
    refused("the joints", infer, shown(1)[0], [skill, lt.ProMP().fit(renamed)])


@pytest.mark.parametrize("samples", [2, 40])
def test_the_log_likelihood_is_the_density_of_the_samples(samples, skills, family):
    skill, motion = skills[0], family(0.11, count=1, seed=4)[0]
    rows = np.linspace(0, 149, samples).astype(int)
    seen = lt.Trajectory(motion.times[rows], motion.positions[rows])
    phases = (seen.times - seen.times[0]) / (seen.times[-1] - seen.times[0])
    every = np.kron(np.eye(2), skill.basis(phases))
    root = skill.weights.steady_root
    noise = np.diag(np.repeat(skill.noise, samples))
    spread = multivariate_normal(
        every @ skill.weights.mean, every @ root @ root.T @ every.T + noise
    )
    density = spread.logpdf(seen.positions.T.ravel())
    assert skill.log_likelihood(seen) == pytest.approx(density, rel=1e-6)


U = np.linspace(0.0, 1.0, 101)
SEEN = 31  # of 101 samples
SPREAD = 0.155  # standard deviation of the random families' weights, m


def others_rows(functions):
    centres = np.linspace(0.0, 1.0, functions)
    rows = np.exp(-0.5 * ((U[:, None] - centres) * (functions - 1)) ** 2)
    return rows / rows.sum(axis=1, keepdims=True)


def random_family(rng, *, factors=5, size=2, functions=12):
    """Draws motions whose weights of another basis have a random covariance of this rank."""
    rows = others_rows(functions)
    mean = np.cumsum(0.1 * rng.normal(size=(functions, size)), axis=0)
    loads = SPREAD / np.sqrt(factors) * rng.normal(size=(factors, functions, size))

    def draw(count):
        drawn = mean + np.einsum("nf,fkd->nkd", rng.normal(size=(count, factors)), loads)
        return rows @ drawn + 0.001 * rng.normal(size=(count, len(U), size))

    return draw


def least_error(count, *, factors, size=2, functions=12, families=200):
    """The error of a forecast that knows a family's mean and covariance, over the plain mean's."""
    rng, rows = np.random.default_rng(0), others_rows(functions)
    left = plain = 0.0
    for _ in range(families):
        loads = SPREAD / np.sqrt(factors) * rng.normal(size=(factors, functions, size))
        values = np.einsum("uk,fkd->fud", rows, loads)
        seen, end = values[:, :SEEN].reshape(factors, -1), values[:, -1]
        inside = seen.T @ seen + 0.001**2 * np.eye(seen.shape[1])
        known = end.T @ seen @ np.linalg.solve(inside, seen.T @ end)
        left += np.trace(end.T @ end - known)
        plain += np.trace(end.T @ end) * (1.0 + 1.0 / count)
    return np.sqrt(left / plain)


def forecasts(count, *, families=12, tests=4, weights=20, pace=0.0, rate=0.0, **family):
    """Errors at the end over plain means', how often regions held it, and plain means' errors."""
    errors, plain, inside, normal = [], [], [], []
    for seed in range(families):
        rng = np.random.default_rng(seed)
        draw = random_family(rng, **family)

        def performed(path, rng=rng):
            warped = U + rate * rng.normal() * U * (1.0 - U)
            path = np.stack([np.interp(warped, U, column) for column in path.T], axis=1)
            return lt.Trajectory(2.0 * np.exp(pace * rng.normal()) * U, path)

        skill = lt.ProMP(weights=weights).fit([performed(path) for path in draw(count)])
        for motion in map(performed, draw(tests)):
            found = infer(motion[:SEEN], [skill])
            (ahead,) = found.skills
            mean, covariance = ahead.distribution([ahead.duration])
            missed = motion.positions[-1] - mean[0]
            errors.append(np.linalg.norm(missed))
            plain.append(np.linalg.norm(motion.positions[-1] - skill.generate().positions[-1]))
            inside.append(found.region([ahead.duration]).contains(motion.positions[-1:])[0])
            squared = missed @ np.linalg.solve(covariance[0] + np.diag(ahead.noise), missed)
            normal.append(squared <= chi2.ppf(0.95, len(missed)))
    return np.mean(errors) / np.mean(plain), np.mean(inside), np.mean(normal), np.mean(plain)


@pytest.mark.parametrize(("count", "most"), [(4, 1.1), (6, 1.02), (12, 0.75), (40, 0.62)])
def test_forecasts_are_nearer_than_the_mean_and_know_how_near(count, most):
    few, many = (forecasts(count, factors=factors) for factors in (5, 10))
    assert max(few[0], many[0]) <= most
    assert 0.9 <= 0.5 * (few[1] + many[1]) <= 0.99  # the regions
    assert 0.9 <= 0.5 * (few[2] + many[2]) <= 0.99  # those of a normal distribution
    assert 0.108 <= min(few[3], many[3]) <= max(few[3], many[3]) <= 0.138  # plain means, m


@pytest.mark.parametrize(("count", "most"), [(4, 1.1), (6, 1.02), (12, 1.02), (40, 0.92)])
def test_forecasts_of_motions_of_full_rank_are_near_what_can_be_known(count, most):
    """Who knows mean and covariance of such motions still misses by 0.7 of the plain mean."""
    error, inside, normal, _ = forecasts(count, factors=24)
    assert least_error(count, factors=24) > 0.62
    assert error <= most
    assert inside >= 0.9
    assert normal >= 0.9


def test_what_is_known_of_a_motion_of_full_rank_after_30_percent():
    least = [least_error(count, factors=24) for count in (4, 6, 12, 40)]
    np.testing.assert_allclose(least, (0.67, 0.70, 0.72, 0.74), atol=0.01)


def test_hundreds_of_demonstrations_forecast_too():
    (error, *_) = forecasts(300, factors=10, families=1, tests=2)
    assert error <= 0.62


def test_regions_hold_for_other_columns_weights_paces_and_durations():
    for count, families in ((4, 20), (12, 10)):
        error, inside, *_ = forecasts(
            count, size=3, functions=8, weights=12, pace=0.15, rate=0.3, families=families
        )
        assert error <= 1.0
        assert inside >= 0.9


def test_regions_hold_where_random_demonstrations_are_taken_for_modes():
    held = []
    for seed, factors in ((4, 5), (18, 10), (20, 10)):
        draw = random_family(np.random.default_rng(seed), factors=factors)
        skill = lt.ProMP(weights=20).fit([lt.Trajectory(2.0 * U, path) for path in draw(4)])
        assert min(len(mode.experience.curves) for mode in skill.modes) == 1
        for path in draw(8):
            found = infer(lt.Trajectory(2.0 * U, path)[:SEEN], [skill])
            ahead = found.region(U[SEEN:] * found.durations[0])
            held.append(ahead.contains(path[SEEN:]).mean())
    assert 0.92 <= np.mean(held) <= 0.99


def test_regions_of_rests_from_four_demonstrations_are_no_wider_than_stated():
    held = []
    for seed, factors in itertools.product(range(1000, 1010), (10, 24)):
        draw = random_family(np.random.default_rng(seed), factors=factors)
        shown = [lt.Trajectory(2.0 * U, path) for path in draw(4)]
        skill = lt.ProMP(weights=20).fit(shown, outliers="keep")
        for path in draw(4):
            found = infer(lt.Trajectory(2.0 * U, path)[:SEEN], [skill])
            ahead = found.region(U[SEEN:] * found.durations[0])
            held.append(ahead.contains(path[SEEN:]).mean())
    assert 0.92 <= np.mean(held) <= 0.99


@pytest.mark.parametrize("motion", ["Sshape", "Trapezoid", "WShape"])
def test_a_forecast_ends_where_all_demonstrations_end(motion):
    left_out, *shown = (each.motion for each in lt.io.lasa.load(motion))
    skill = lt.ProMP().fit(shown)
    for seen in (300, 500, 700):
        (ahead,) = infer(left_out[:seen], [skill]).skills
        end = ahead.generate().positions[-1]
        assert np.linalg.norm(end - left_out.positions[-1]) < 0.01  # mm; they are 50 mm long


def nearest_end(seen, shown):
    """The end of the demonstration whose beginning is nearest at its best phase."""
    u, ends = normalised_times(seen.times), {}
    for each in shown:
        for end in np.linspace(0.05, 1.0, 20):
            path = lerp(end * u, normalised_times(each.times), each.positions)
            ends[np.linalg.norm(path - seen.positions)] = each.positions[-1]
    return ends[min(ends)]


def test_left_out_recordings_end_no_farther_off_than_the_mean_or_the_nearest_one(recordings):
    """Strokes, reaches and poses of people; errors in extents, averaged over the sets."""
    files = sorted((recordings / "strokes").glob("*.npz"))
    errors = np.array([errors_at_the_end([each.motion for each in read(f)]) for f in files])
    ours, *baselines = errors.mean(axis=0)
    assert len(files) == 15
    assert (ours <= np.min(baselines, axis=0)).all()
    assert ours[2] < min(ours[:2])  # more is seen, and known


def errors_at_the_end(motions):
    """Mean errors (3, 3) of forecast, mean and nearest end after 30, 50 and 70 %, in extents."""
    errors = []
    for i in range(0, len(motions), 4):
        left_out, shown = motions[i], motions[:i] + motions[i + 1 :]
        mean = np.mean([each.positions[-1] for each in shown], axis=0)
        skill = lt.ProMP().fit(shown)
        for samples in (60, 100, 140):  # of 200
            seen = left_out[:samples]
            (ahead,) = infer(seen, [skill]).skills
            ends = [ahead.generate().positions[-1], mean, nearest_end(seen, shown)]
            missed = np.linalg.norm(np.array(ends) - left_out.positions[-1], axis=1)
            errors.append(missed / np.linalg.norm(np.ptp(left_out.positions, axis=0)))
    return np.mean(np.reshape(errors, (-1, 3, 3)), axis=0).T


def test_forecasts_of_poses_do_not_depend_on_the_unit_of_length(recordings):
    motions = [each.motion for each in read(recordings / "strokes" / "puma-pouring.npz")]

    def forecast(factor):
        scaled = [replace(each, positions=factor * each.positions) for each in motions]
        (ahead,) = infer(scaled[0][:60], [lt.ProMP().fit(scaled[1:])]).skills
        return ahead.generate().positions[-1] / factor

    np.testing.assert_allclose(forecast(1e-3), forecast(1.0), atol=0.1)  # mm


def test_a_saved_skill_forecasts_the_same_and_an_older_file_as_a_normal_distribution(
    skills, family, tmp_path
):
    seen = family(0.11, count=1, seed=4)[0][:40]
    skills[0].save(tmp_path / "skill.npz")
    found, again = infer(seen, skills[:1]), infer(seen, [lt.load_skill(tmp_path / "skill.npz")])
    np.testing.assert_array_equal(found.skills[0].weights.mean, again.skills[0].weights.mean)
    with np.load(tmp_path / "skill.npz") as arrays:
        kept = {name: arrays[name] for name in arrays.files if name not in ("curves", "paces")}
    np.savez(tmp_path / "old.npz", **kept)
    old = infer(seen, [lt.load_skill(tmp_path / "old.npz")])
    assert np.isinf(old.freedom[0])
    assert np.isfinite(old.region([0.5]).reach).all()


def test_a_region_is_that_of_a_skill_and_a_probability(skills, family):
    seen = family(0.11, count=1, seed=4)[0][:40]
    found = infer(seen, skills)
    times = np.linspace(0.0, found.durations[0], 5)
    narrow, wide = (found.region(times, probability=p) for p in (0.5, 0.99))
    assert (narrow.reach < wide.reach).all()
    assert narrow.contains(narrow.mean).all()
    assert not narrow.contains(narrow.mean + wide.reach).any()
    np.testing.assert_array_equal(found.region(times, skill=0).mean, narrow.mean)
    for wrong in ({"probability": 1.0}, {"skill": 2}):
        refused(next(iter(wrong)), found.region, times, **wrong)


def test_single_demonstrations_and_partial_ones_forecast_too(family):
    seen = family(0.11, count=1, seed=4)[0][:40]
    for count in (1, 2, 3):
        shown = family(0.1, count=count)
        for estimator in ("least_squares", "em"):
            skill = lt.ProMP(weights=8, estimator=estimator).fit(shown)
            assert np.isfinite(infer(seen, [skill]).region([1.0]).reach).all()


@pytest.mark.parametrize(("count", "judged"), [(2, 0), (3, 3), (4, 4)])
def test_from_three_demonstrations_on_each_is_forecast_from_the_others(count, judged, family):
    skill = lt.ProMP(weights=10).fit(family(0.1, count=count))
    assert len(skill.experience.left_out) == judged
    for (curve, _), demonstrated in zip(
        skill.experience.left_out, family(0.1, count=count), strict=False
    ):
        shown = skill.basis(np.linspace(0.0, 1.0, 150)) @ curve.reshape(2, -1).T
        np.testing.assert_allclose(shown, demonstrated.positions, atol=5e-3)
