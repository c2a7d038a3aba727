"""Cleaned and summarised recordings."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused
from scipy.ndimage import percentile_filter

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import Recording
from leadthrough.preprocess import clean, cut_at_gaps
from leadthrough.preprocess.clean import _ranked, summarize

TIMES = np.arange(201) / 100.0
SWING = np.column_stack([np.sin(2.0 * TIMES), np.cos(3.0 * TIMES)])
TURNED = lt.rotations.exp(np.column_stack([TIMES, 0.5 * TIMES**2, 0.0 * TIMES]))
JOINTS = Recording(TIMES, SWING, joint_names=("a", "b"), name="swing")
FOUR = Recording(
    TIMES, np.hstack([SWING, SWING[:, ::-1]]), joint_names=tuple(f"joint_{i}" for i in range(4))
)
POSES = Recording(TIMES, np.column_stack([SWING, TIMES]), TURNED, name="tool")


def with_values(recording, field, rows, values):
    changed = getattr(recording, field).copy()
    changed[rows] = values
    return replace(recording, **{field: changed})


@pytest.mark.parametrize("recording", [JOINTS, POSES, replace(POSES, orientations=None)])
def test_a_clean_recording_stays_as_it_is(recording):
    demonstration, report = clean(recording)
    assert demonstration.name == recording.name
    assert np.array_equal(demonstration.motion.times, TIMES)
    assert np.array_equal(demonstration.motion.positions, recording.positions)
    assert report.faults == 0
    assert (report.read, report.left, report.gaps, report.pauses) == (201, 201, (), ())
    again, _ = clean(demonstration)
    assert np.array_equal(again.motion.positions, demonstration.motion.positions)
    assert type(again.motion) is type(demonstration.motion)


def test_samples_without_a_number_are_left_out():
    recording = with_values(JOINTS, "positions", (40, 0), np.nan)
    recording = with_values(recording, "positions", (41, 1), np.inf)
    recording = with_values(recording, "times", 99, np.nan)
    demonstration, report = clean(recording)
    assert report.invalid == (40, 41, 99)
    kept = np.delete(np.arange(201), [40, 41, 99])
    assert np.array_equal(demonstration.motion.times, TIMES[kept])
    assert "3 samples with missing numbers, left out: 40, 41, 99" in str(report)


@pytest.mark.parametrize("recording", [POSES, replace(POSES, orientations=None)])
def test_zeros_of_a_tracker_without_a_target_are_refused_and_left_out(recording, tmp_path):
    dropped = with_values(recording, "positions", slice(100, 110), 0.0)
    lt.write_motion(dropped.motion(), tmp_path / "dropped.csv")
    message = "line 102: the position is 0, far off, .*`leadthrough clean`"
    refused(message, lt.read_motion, tmp_path / "dropped.csv")
    demonstration, report = clean(with_values(dropped, "positions", 50, np.nan))
    assert report.invalid == (50, *range(100, 110))
    assert np.abs(demonstration.motion.positions).max(axis=1).min() > 0.5
    through = replace(recording, positions=recording.positions - recording.positions[100])
    assert clean(through)[1].faults == 0  # a motion may pass the origin, and grippers leap from it
    assert not clean(
        replace(JOINTS, positions=np.repeat([0.0, 0.04], [101, 100])[:, None].repeat(2, 1))
    )[1].invalid


@pytest.mark.parametrize("recording", [POSES, FOUR])
def test_a_frozen_position_that_leaps_is_refused_and_left_out(recording, tmp_path):
    last = recording.positions[100]
    frozen = with_values(recording, "positions", slice(100, 130), last)
    lt.write_motion(frozen.motion(), tmp_path / "frozen.csv")
    message = "line 103: the position stands still and then leaps, .*`leadthrough clean`"
    refused(message, lt.read_motion, tmp_path / "frozen.csv")
    assert clean(frozen)[1].invalid == tuple(range(101, 130))
    slow = recording.positions.repeat(10, 0)  # of a sensor whose numbers are equal all the time
    assert not clean(Recording(np.arange(2010.0), slow))[1].invalid
    rested = np.vstack([np.repeat(recording.positions[:1], 50, 0), recording.positions[:151]])
    assert not clean(replace(recording, positions=rested))[1].invalid


@pytest.mark.parametrize("late", [0.0, 0.003])
def test_a_clock_that_starts_again_is_refused_and_a_late_block_is_sorted(late):
    times, line = np.arange(100) * 0.01, np.linspace(0.0, 1.0, 100)[:, None]
    twice = Recording(np.r_[times, times + late], np.vstack([line, line + 0.3]))
    refused(f"times start again, with {late:g} s behind 0.99 s", clean, twice)
    block = np.r_[0:30, 60:100, 30:60]
    cleaned, _ = clean(Recording(times[block] + late, line[block]))
    np.testing.assert_array_equal(cleaned.motion.positions, line)


def test_samples_out_of_order_are_sorted_and_repeated_ones_stay_once():
    rows = np.array([*range(50), 52, 50, 51, 51, *range(53, 201)])
    shuffled = replace(JOINTS, times=TIMES[rows], positions=SWING[rows])
    demonstration, report = clean(shuffled)
    assert np.array_equal(demonstration.motion.positions, SWING)
    assert (report.unordered, report.repeated) == (3, 1)


def test_quaternions_get_one_sign_and_length():
    recording = with_values(POSES, "orientations", slice(30, 60), -1.3 * TURNED[30:60])
    recording = with_values(recording, "orientations", 100, 0.0)
    demonstration, report = clean(recording)
    assert (report.flipped, report.unnormalised, report.invalid) == (30, 30, (100,))
    expected = np.delete(TURNED, 100, axis=0)
    np.testing.assert_allclose(demonstration.motion.orientations, expected, atol=1e-12)


def wrapped(angles):
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def test_leaps_of_a_joint_by_a_whole_turn_are_made_continuous(tmp_path):
    positions = SWING + np.array([0.0, 0.5 - np.pi])
    recording = replace(JOINTS, positions=np.column_stack([SWING[:, 0], wrapped(positions[:, 1])]))
    for options in ({}, {"rate": 250.0}, {"smoothing": 0.1}):
        demonstration, report = clean(recording, **options)
        continuous, none = clean(replace(JOINTS, positions=positions), **options)
        np.testing.assert_allclose(
            demonstration.motion.positions, continuous.motion.positions, atol=1e-9
        )
        assert (report.turns, none.turns) == (2, 0)
    path = tmp_path / "wrapped.csv"
    columns = np.column_stack([TIMES, recording.positions])
    np.savetxt(
        path, columns, delimiter=",", header="time,joint_1,joint_2", comments="", fmt="%.17g"
    )
    with pytest.warns(UserWarning, match="leaps by whole turns that encoders make: joint_2"):
        (shown,) = lt.read_demonstrations(path, rest=np.inf)
    np.testing.assert_allclose(shown.motion.positions, positions, atol=1e-9)


@pytest.mark.parametrize("rows", [[60], [60, 61], [60, 61, 62], [30, 90, 150], [0], [200]])
def test_spikes_are_left_out_and_nothing_else(rows):
    recording = with_values(JOINTS, "positions", (rows, 1), 9.0)
    demonstration, report = clean(recording)
    assert report.spikes == tuple(TIMES[rows].tolist())
    assert np.array_equal(demonstration.motion.positions, np.delete(SWING, rows, axis=0))
    left, report = clean(recording, spike_factor=None)
    assert report.spikes == ()
    assert len(left.motion.times) == 201


@pytest.mark.parametrize("samples", [8, 30, 1200])
def test_spikes_are_judged_by_percentiles_of_a_mirrored_window(samples):
    values = np.cumsum(np.random.default_rng(1).normal(size=(samples, 3)), axis=0).round(1)
    for size, percent in ((7, 50), (51, 50), (51, 80)):
        expected = percentile_filter(values, percent, size=(size, 1), mode="mirror")
        np.testing.assert_array_equal(_ranked(values, size, percent), expected)


def test_a_leap_of_the_rotation_is_a_spike_too():
    recording = with_values(POSES, "orientations", 60, [0.0, 0.0, 0.0, 1.0])
    demonstration, report = clean(recording)
    assert report.spikes == (TIMES[60],)
    expected = np.delete(TURNED, 60, axis=0)
    np.testing.assert_allclose(demonstration.motion.orientations, expected, atol=1e-12)


@given(seed=st.integers(0, 1000), noise=st.floats(0.0, 0.01))
def test_a_trembling_hand_has_few_spikes(seed, noise):
    rng = np.random.default_rng(seed)
    recording = replace(JOINTS, positions=SWING + noise * rng.standard_normal(SWING.shape))
    assert len(clean(recording)[1].spikes) <= 1


def test_a_hand_that_stops_short_or_turns_back_makes_no_spike():
    way = np.interp(TIMES, [0, 0.5, 0.9, 1.0, 1.5, 2.0], [0, 0, 1, 0.96, 0.96, -1])
    assert clean(replace(JOINTS, positions=way[:, None], joint_names=("a",)))[1].spikes == ()


def test_real_recordings_have_hardly_a_spike_and_long_pauses(recordings):
    columns = {"joints": [f"joint_{i}" for i in range(1, 8)]}
    path = recordings / "panda_execution" / "trial1.csv"
    (recording,) = lt.io.read_recordings(path, columns=columns, rate=20)
    demonstration, report = clean(recording, longest_pause=0.5)
    assert len(report.spikes) < 5
    assert report.removed > 60
    left = 284.9 - report.removed - sum(report.still)
    assert demonstration.motion.duration == pytest.approx(left)


def test_gaps_are_told_and_long_ones_refused_or_cut():
    kept = np.delete(np.arange(201), [*range(50, 60), *range(100, 180)])
    recording = replace(JOINTS, times=TIMES[kept], positions=SWING[kept])
    refused(r"no sample from 0.99 to 1.8 s; .* now 0.5 s", clean, recording)
    _, report = clean(recording, longest_gap=1.0)
    assert report.gaps == ((0.49, 0.6), (0.99, 1.8))
    pieces = cut_at_gaps(recording)
    assert [piece.name for piece in pieces] == ["swing 1", "swing 2"]
    assert [len(piece.times) for piece in pieces] == [90, 21]
    assert len(cut_at_gaps(recording, longest_gap=0.05)) == 3


def test_pauses_are_told_and_shortened_on_demand():
    times = np.arange(401) / 100.0
    way = np.interp(times, [0, 1, 3, 4], [0, 1, 1, 2])[:, None]
    recording = Recording(
        times, way, joint_names=("a",), events=(lt.Event(2.8, "grasp"), lt.Event(3.5, "lift"))
    )
    demonstration, report = clean(recording)
    ((start, end),) = report.pauses
    assert (start, end) == pytest.approx((1.22, 2.78), abs=0.02)
    assert demonstration.motion.duration == 4.0
    short, report = clean(recording, longest_pause=0.2)
    assert report.removed == pytest.approx(end - start - 0.2)
    assert short.motion.duration == pytest.approx(4.0 - report.removed)
    assert np.abs(np.diff(short.motion.positions[:, 0])).max() < 0.011
    late = [event.time for event in short.events]
    assert late == pytest.approx([2.8 - report.removed, 3.5 - report.removed])


def test_the_rate_may_be_chosen():
    demonstration, report = clean(POSES, rate=250)
    motion = demonstration.motion
    np.testing.assert_allclose(motion.times, np.arange(501) / 250, atol=1e-12)
    np.testing.assert_allclose(motion.positions[:, 0], np.sin(2 * motion.times), atol=1e-4)
    expected = lt.rotations.exp(
        np.column_stack([motion.times, 0.5 * motion.times**2, 0.0 * motion.times])
    )
    assert lt.rotations.distance(motion.orientations, expected).max() < 1e-4
    assert report.rate == 250


def test_smoothing_gives_the_derivatives_of_what_was_meant():
    rng = np.random.default_rng(0)
    noisy = replace(JOINTS, positions=SWING + 1e-3 * rng.standard_normal(SWING.shape))
    demonstration, report = clean(noisy, smoothing=0.3)
    motion = demonstration.motion
    assert report.smoothing == 0.3
    assert report.rate == pytest.approx(100)
    inside = slice(20, -20)
    velocities = np.column_stack([2 * np.cos(2 * TIMES), -3 * np.sin(3 * TIMES)])
    accelerations = np.column_stack([-4 * np.sin(2 * TIMES), -9 * np.cos(3 * TIMES)])
    assert np.abs(motion.positions - SWING)[inside].max() < 2e-3
    assert np.abs(motion.velocities - velocities)[inside].max() < 0.05
    assert np.abs(motion.accelerations - accelerations)[inside].max() < 1.0


def test_events_outside_of_what_is_left_come_at_its_ends():
    recording = replace(
        with_values(JOINTS, "positions", (0, 0), np.nan), events=(lt.Event(0.0, "start"),)
    )
    assert clean(recording)[0].events == (lt.Event(0.01, "start"),)


def test_the_report_is_a_text_and_a_dict():
    _, report = clean(with_values(JOINTS, "positions", (60, 1), 9.0), rate=50, smoothing=0.2)
    assert str(report).splitlines() == [
        "201 samples read, 101 left",
        "1 spike, left out: 0.6 s",
        "resampled at 50 Hz",
        "smoothed with a window of 0.2 s",
    ]
    assert report.as_dict()["spikes"] == (0.6,)
    with pytest.raises(AttributeError):
        report.read = 3


@given(st.data())
def test_any_recording_is_cleaned_or_refused(data):
    count = data.draw(st.integers(0, 12))
    numbers = st.floats(-10, 10) | st.just(np.nan) | st.just(np.inf) | st.just(1e300)
    times = data.draw(st.lists(numbers, min_size=count, max_size=count))
    rows = data.draw(st.lists(st.tuples(*[numbers] * 7), min_size=count, max_size=count))
    values = np.array(rows, float).reshape(count, 7)
    recording = Recording(np.array(times, float), values[:, :3], values[:, 3:])
    try:
        demonstration, report = clean(recording, longest_gap=100, longest_pause=1, smoothing=2)
    except InvalidInput:
        return
    assert len(demonstration.motion.times) == report.left


CLOCK = np.arange(101) / 50.0
WAY = np.column_stack([np.sin(CLOCK), CLOCK])
ARM = Recording(CLOCK, WAY, joint_names=("a", "b"), events=(lt.Event(1, "grasp"),), name="arm")


def test_a_summary_tells_what_there_is():
    found = summarize(ARM)
    assert (found.kind, found.joints, found.samples) == ("joints", ("a", "b"), 101)
    assert (found.duration, found.rate) == pytest.approx((2.0, 50.0))
    assert found.upper == pytest.approx((1.0, 2.0), abs=1e-3)
    assert (found.events, found.remarks, found.report.faults) == (("grasp",), (), 0)
    assert str(found).splitlines() == [
        "arm: joints, 101 samples, 2 s at 50 Hz",
        "  range in rad (m): 0 to 1, 0 to 2",
        "  joints a, b",
        "  events grasp",
    ]
    assert found.as_dict()["report"]["read"] == 101


def test_faults_are_counted_and_gaps_of_any_length_told():
    values = WAY.copy()
    values[[3, 4]] = np.nan
    times = CLOCK + 100.0 * (CLOCK > 1.0)
    found = summarize(replace(ARM, times=times, positions=values, events=()))
    assert found.report.invalid == (3, 4)
    assert len(found.report.gaps) == 1
    assert "2 samples with missing numbers, left out: 3, 4" in str(found)


@pytest.mark.parametrize(
    ("changes", "remark"),
    [
        ({"times": 1e-9 * CLOCK}, "Hz: are the times in s"),
        ({"times": 1000.0 * CLOCK}, "Hz: are the times in s"),
        ({"positions": np.ones((101, 2))}, "nothing moves"),
        ({"positions": np.full((101, 2), np.nan)}, "expected some samples without missing numbers"),
        (
            {
                "positions": 400.0 * np.ones((101, 3)),
                "orientations": np.tile([1.0, 0, 0, 0], (101, 1)),
                "joint_names": None,
            },
            "positions up to 400 m: are they in m",
        ),
        (
            {"positions": 400.0 * np.ones((101, 3)), "joint_names": None},
            "positions up to 400 m: are they in m",
        ),
    ],
)
def test_what_looks_wrong_is_remarked(changes, remark):
    found = summarize(replace(ARM, events=(), **changes))
    assert any(remark in each for each in found.remarks)
    assert f"! {found.remarks[0]}" in str(found)


def test_times_since_1970_are_told_apart():
    times = np.arange(200) / 100.0
    positions = np.outer(np.clip(times - 1.0, 0.0, None), np.ones(3))
    told = str(summarize(Recording(1.6e9 + times, positions)))
    assert re.search(r"1 pause: 1600000000 to 1600000000\.\d+ s", told)


def test_impossible_options_and_what_is_no_recording_are_refused():
    for options, message in [
        ({"spike_factor": 0}, "spike_factor: "),
        ({"longest_gap": -1}, "longest_gap: "),
        ({"pause": np.nan}, "pause: "),
        ({"longest_pause": 0}, "longest_pause: "),
        ({"speed": "slow"}, "speed: "),
        ({"angular_speed": 0}, "angular_speed: "),
        ({"rate": 0}, "rate: "),
        ({"rate": 1e12}, "rate: expected at most 10,000,000 samples"),
        ({"smoothing": 0.001}, r"smoothing: expected 0.04 to 2 s, at least 5 samples"),
        ({"smoothing": 1e300}, r"smoothing: expected 0.04 to 2 s, at least 5 samples"),
    ]:
        refused(message, clean, JOINTS, **options)
    for wrong in (None, SWING, [JOINTS]):
        refused("recording: expected a Recording", clean, wrong)
        refused("recording: expected a Recording", cut_at_gaps, wrong)
    nothing = Recording(np.zeros(0), np.zeros((0, 2)))
    for function in (clean, cut_at_gaps):
        refused("got none", function, nothing)
    refused("expected a Recording, got ndarray", summarize, WAY)
