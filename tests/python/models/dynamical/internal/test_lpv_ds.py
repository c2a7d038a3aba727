"""LPV-DS and its number of components, by cross-validation."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.models import LPVDS
from leadthrough_studies import metrics


def components(skill):
    return len(skill.field.matrices)


def area(model, shown):
    skill = model.fit(shown)
    errors = [
        metrics.reproduction_errors(each.motion, skill.generate(start=each.motion.positions[0]))
        for each in shown
    ]
    return float(np.mean([each.swept_error_area for each in errors]))


def test_a_winding_motion_has_components_enough():
    shown = lt.io.lasa.load("Worm")
    chosen = area(LPVDS(), shown)
    assert chosen < 40.0  # mm^2; 619 with the four components of the least BIC
    assert chosen < 0.5 * area(LPVDS(components=4), shown)


def test_the_number_is_the_same_in_another_unit_and_again():
    shown = [each.motion for each in lt.io.lasa.load("Spoon")]
    in_m = [lt.Trajectory(each.times, 1e-3 * each.positions) for each in shown]
    first = LPVDS().fit(shown)
    assert components(first) == components(LPVDS().fit(in_m)) == components(LPVDS().fit(shown))


def test_a_straight_motion_needs_few():
    t = np.linspace(0.0, 1.0, 100)
    rise = t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    shown = [lt.Trajectory(t, np.outer(rise, [1.0, slope])) for slope in (-0.1, 0.0, 0.1)]
    assert components(LPVDS().fit(shown)) <= 6


@pytest.mark.parametrize("samples", [12, 1000])
def test_a_single_demonstration_is_left_out_by_its_samples(samples):
    t = np.linspace(0.0, 1.0, samples)
    path = np.column_stack([40.0 * t, 10.0 * np.sin(2.0 * np.pi * t)])
    shown = lt.Trajectory(2.0 * t, path)
    skill = LPVDS().fit([shown])
    made = skill.generate(start=path[0])
    assert components(skill) > 2
    assert lt.preprocess.frechet_distance(made.positions, path) < 4.0
