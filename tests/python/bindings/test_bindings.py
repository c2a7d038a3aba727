"""Every binding of the compiled core, called as it should be and in wrong ways: see calls.py."""

import contextlib
import re
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from bindings.calls import CALLS, OPTIONAL

# Arguments of as many numbers, rows or cells as one likes; the sizes of options are looked at
# where they are used.
FREE = dict(
    re.findall(
        r"(\S+?)\(([^)]*)\)",
        """
    ArrivalField(cells speed)  SpeedMap.at(cells)  SpeedMap.fastest(blocks)
    FreeSpeedMap.at(cells)  FreeSpeedMap.fastest(blocks)
    Chain.forward_kinematics(q)  Chain.pose(q)  bridge_on_time(target)  bridge_to_start(target)
    condition_at(position noise)  dmp_poses(phases)
    first_contact(samples)  first_excess(samples)
    eased(path)  slowed(path)  stopped(path)  with_rates(start)
    DmpForces(nodes)  DmpPath(coefficients)  dmp_peak_speeds(phases)
    IkOptions(posture reference)  PursuitOptions(acceleration velocity)  TimedPath(coefficients)
    Shape.distances(points)  all_finite(values)
    arc_lengths(points)  by_arc_length(points)  rms_apart(curves)
    cloud_shape(points)  experience_speeds(paths)  tube_speeds(paths)  Walls.distances(cells)
    sample_truncated_gaussian(velocities)  check_motion(q)  clear_batch(q)
    condition_weights(basis)  curves_over(basis weights)
    curves_over_basis(phases centres factors weights)  descend(arrival)  directions(arrival points)
    distance_transform(mask)  dmp_orientations(values)  dmp_rollout(phases)
    dmp_rollout_around(phases)  dtw_distance(a b)  dtw_path(a b)  frechet_distance(a b)
    jacobian(q)  jacobian_of_one(q)
    longest_step(q)  march(cells speed)  mass_matrix(q)  nearest_bodies(q)
    nearest_sources(arrival)  normalised_basis(centres phases)  posture_task(q velocity)
    product(left right)  solve_definite(right)
    fit_spline(q)  smooth_spline(q)  rows_apart(q)  time_lines(points)
    so3_exp(rotation_vectors)  so3_from_matrix(matrices)  so3_left_jacobian(rotation_vectors)
    so3_left_jacobian_inverse(rotation_vectors)  so3_lift(quaternions)  so3_log(quaternions)
    so3_mean(layers weights)  so3_slerp_through(at)  so3_to_matrix(quaternions)
    bezier_values(points fractions)  cubic_through(q)  spline_slopes(q)
    polynomial_values(knots coefficients times)
        """,
    )
)


def wrong_sizes(value: np.ndarray) -> Iterator[np.ndarray]:
    for axis in range(value.ndim):
        yield np.concatenate([value, value], axis) if value.size else np.ones(value.shape[0] + 1)
        if value.shape[axis]:
            yield np.ascontiguousarray(np.delete(value, -1, axis))


def test_calls_give_the_known_result(
    function: Callable[..., Any], arguments: dict[str, Any], expected: Any
) -> None:
    result = function(**arguments)
    first = result[0] if isinstance(result, tuple) else result
    if isinstance(expected, str):
        assert first == expected
    else:
        np.testing.assert_allclose(np.asarray(first), np.asarray(expected), atol=1e-5)


def test_every_function_class_and_method_is_called(
    compiled: ModuleType, called: set[str], made: list[Any]
) -> None:
    wanted = set()
    for name, thing in vars(compiled).items():
        if name.startswith("_") or isinstance(thing, ModuleType):
            continue
        wanted.add(name)
        if isinstance(thing, type):
            methods = [key for key, value in vars(thing).items() if callable(value)]
            wanted |= {f"{name}.{key}" for key in methods if not key.startswith("_")}
    assert wanted <= called | {type(thing).__name__ for thing in made}


def test_members_of_none_and_of_objects_without_init_end_no_process(compiled: ModuleType) -> None:
    for thing in [each for each in vars(compiled).values() if isinstance(each, type)]:
        for name, member in vars(thing).items():
            getter = member.fget if isinstance(member, property) else member
            for owner in (None, thing.__new__(thing)):
                if callable(getter) and name not in ("__new__", "__doc__"):
                    with contextlib.suppress(TypeError, RuntimeError, AttributeError):
                        getter(owner)


def test_an_object_without_init_in_place_of_an_argument_raises(
    function: Callable[..., Any], arguments: dict[str, Any], needed: str, compiled: ModuleType
) -> None:
    kind = type(arguments[needed])
    if kind in vars(compiled).values():
        with pytest.raises((TypeError, RuntimeError)):
            function(**arguments | {needed: kind.__new__(kind)})


def test_optional_arguments_are_computed_with() -> None:
    for function, arguments, _ in CALLS:
        for name in set(arguments) & set(OPTIONAL.get(function.__name__, ())):
            function(**arguments | {name: None})


def test_none_in_place_of_an_argument_raises(
    function: Callable[..., Any], arguments: dict[str, Any], needed: str
) -> None:
    with pytest.raises(TypeError):
        function(**arguments | {needed: None})


def test_arrays_of_another_size_raise_or_are_taken_whole(
    function: Callable[..., Any],
    arguments: dict[str, Any],
    sized: str,
    request: pytest.FixtureRequest,
) -> None:
    title = request.node.callspec.id.rpartition("-")[0]
    free = FREE.get(re.sub("_?float(32|64)", "", title, flags=re.IGNORECASE), "").split()
    for value in wrong_sizes(arguments[sized]):
        try:
            function(**arguments | {sized: value})
        except (TypeError, ValueError, IndexError):
            continue
        assert sized in free, f"took {value.shape} for {arguments[sized].shape}"
