import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.planning import nearest_sources


def distances(shape, sources, spacing):
    axes = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    x = np.stack(axes, axis=-1) * spacing
    return np.linalg.norm(
        x[None] - (sources * spacing).reshape(-1, *[1] * len(shape), len(shape)), axis=-1
    )


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", [(90, 110), (36, 30, 40)])
@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), count=st.integers(1, 7))
def test_at_constant_speed_labels_name_the_nearest_source(shape, order, seed, count):
    rng = np.random.default_rng(seed)
    spacing = rng.choice([1.0, 0.7, 1.6], len(shape))
    sources = rng.integers(0, shape, (count, len(shape)))
    times = lt.arrival_times(np.ones(shape), sources, spacing=spacing, order=order)
    labels = nearest_sources(times, sources, spacing=spacing)
    truth = distances(shape, sources, spacing)
    chosen = np.take_along_axis(truth, labels[None].astype(int), axis=0)[0]
    loss = chosen - truth.min(axis=0)  # twice the distance to the border at most
    assert loss.max() < 4.0 * spacing.max()
    assert np.quantile(loss, 0.97) < 0.5 * spacing.max()


def test_a_border_aslant_to_the_axes_does_not_drift():
    """Far from two sources close together the fronts run nearly parallel along their border."""
    shape, sources = (300, 300), np.array([(2, 9), (9, 2)])
    times = lt.arrival_times(np.ones(shape), sources, order=2)
    labels = nearest_sources(times, sources)
    rows, columns = np.indices(shape)
    assert ((labels == 0) == (rows < columns))[np.abs(rows - columns) > 4].all()
    sources = np.array([(2, 2), (8, 12)])
    truth = distances(shape, sources, np.ones(2))
    labels = nearest_sources(lt.arrival_times(np.ones(shape), sources, order=2), sources)
    wrong = labels != truth.argmin(axis=0)
    assert np.abs(truth[0] - truth[1])[wrong].max() < 1.5


def test_rooms_belong_to_the_source_inside_and_walled_off_cells_to_none():
    speed = np.ones((20, 31))
    speed[:, [10, 20]] = 0.0
    sources = [(5, 3), (10, 15)]
    labels = nearest_sources(lt.arrival_times(speed, sources), sources)
    assert (labels[:, :10] == 0).all()
    assert (labels[:, 11:20] == 1).all()
    assert (labels[:, [10, *range(20, 31)]] == -1).all()
    assert labels.dtype == np.int32


def test_labels_follow_the_quicker_way_where_speed_varies():
    rng = np.random.default_rng(1)
    speed = rng.uniform(0.2, 1.0, (50, 60))
    sources = [(10, 10), (40, 50), (12, 45)]
    labels = nearest_sources(lt.arrival_times(speed, sources), sources)
    each = np.array([lt.arrival_times(speed, source) for source in sources])
    loss = np.take_along_axis(each, labels[None].astype(int), axis=0)[0] - each.min(axis=0)
    assert (loss > 1.0).mean() < 0.03


def test_of_two_sources_in_one_cell_the_first_counts():
    sources = [(3, 3), (3, 3)]
    assert not nearest_sources(lt.arrival_times(np.ones((6, 6)), sources), sources).any()


def test_cells_that_lead_to_no_source_named_have_no_label():
    times = lt.arrival_times(np.ones((6, 30)), [(3, 3), (3, 26)])
    labels = nearest_sources(times, (3, 3))
    assert labels[3, 4] == 0
    assert labels[3, 25] == -1


def test_bad_input_is_refused():
    times = lt.arrival_times(np.ones((6, 6)), (3, 3))
    for name, arguments in {
        "arrival": (np.full((6, 6), np.nan), (3, 3)),
        "sources": (times, (9, 9)),
    }.items():
        with pytest.raises(InvalidInput, match=name):
            nearest_sources(*arguments)
    with pytest.raises(InvalidInput, match="arrival"):
        nearest_sources(times > 0, (3, 3))
    with pytest.raises(InvalidInput, match="spacing"):
        nearest_sources(times, (3, 3), spacing=-1.0)
