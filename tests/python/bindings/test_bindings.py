"""Every binding of the compiled core, called as the package calls it and in wrong ways."""

import contextlib
import re

import numpy as np
import pytest
from bindings.fuzz import members, recorded
from test_stub import arguments_in_module

from leadthrough import _core as core

# Names of arguments that may be None.
OPTIONAL = {
    "IkOptions.__init__": ("axes", "reference", "posture"),
    "TrackOptions.__init__": ("axes",),
    "clear_path": ("axes", "model", "start"),
    "condition_at": ("time", "position", "noise"),
    "Chain.pose": ("q",),
    "MarchingPolicy.__init__": ("barrier",),
    "is_finite_vector": ("value", "size"),
    "jacobian_of_one": ("q",),
    "solve_ik": ("form",),
    "solve_ik_batch": ("form",),
    "solve_ik_all": ("form",),
    "unit_quaternion": ("value",),
}
# Arguments of as many numbers, rows or cells as one likes; the sizes of options are looked at
# where they are used.
FREE = dict(
    re.findall(
        r"(\S+?)\(([^)]*)\)",
        """
    ArrivalField(cells speed)  ArrivalField.update(speed)  Chain.forward_kinematics(q)
    ErrorLoop(values)  ErrorLoop.advance(answer ease)
    Chain.pose(q)  DmpForces(nodes)  DmpPath(coefficients)  Dynamics.mass_matrix(q)
    MarchingPolicy(arrival)  MarchingPolicy.moved(points)  MarchingPolicy.velocities(points)
    PursuitOptions(acceleration velocity)
    Shape.distances(points)  SpeedMap.at(cells)  TimedPath(coefficients)  Walls.distances(cells)
    all_finite(values)  arc_lengths(points)  bezier_values(fractions points)
    bridge_on_time(target)  bridge_to_start(target)  by_arc_length(points)  check_motion(q)
    clear_batch(q)  cloud_shape(points)  condition_at(noise)  connect(goals)  cubic_through(q)
    curves_over(basis weights)  curves_over_basis(centres factors phases weights)
    descend(arrival)  directions(arrival points)  distance_transform(mask)
    dmp_orientations(values)  dmp_peak_speeds(phases)  dmp_poses(phases)  dmp_rollout(phases)
    dmp_rollout_around(phases)  dtw_distance(a b)  dtw_path(a b)  eased(path)
    first_contact(samples)  first_excess(samples)  fit_spline(q)  frechet_distance(a b)
    is_finite_vector(value)  jacobian(q)  jacobian_of_one(q)  joined(target)  longest_step(q)
    march(cells speed)
    nearest_bodies(q)  nearest_sources(arrival)  normalised_basis(centres phases)
    polynomial_values(coefficients times)  posture_task(q velocity)  product(left right)
    rms_apart(curves)  rows_apart(q)  sample_truncated_gaussian(velocities)  slowed(path)
    so3_exp(rotation_vectors)  so3_from_matrix(matrices)  so3_left_jacobian(rotation_vectors)
    so3_left_jacobian_inverse(rotation_vectors)  so3_lift(quaternions)  so3_log(quaternions)
    so3_mean(layers)  so3_slerp_through(at)  so3_to_matrix(quaternions)  solve_definite(right)
    spline_slopes(q)  stopped(path)  time_lines(points)  unit_quaternion(value)
    write_records(values)
        """,
    )
)
# An enumeration, and a bound that its own search alone asks for.
UNCALLED = {"IkMode.__init__", "SpeedMap.fastest"}
NAMES = [name for name, *_ in members(core) if name not in UNCALLED]


@pytest.fixture(scope="module")
def calls():
    return recorded().calls


def wrong_sizes(value):
    for axis in range(value.ndim):
        yield np.concatenate([value, value], axis) if value.size else np.ones(value.shape[0] + 1)
        if value.shape[axis] > 1:
            yield np.ascontiguousarray(np.delete(value, -1, axis))


def places(call):
    """Place, name and value of each argument; the first one of a method is its object."""
    member = call.function.__init__ if isinstance(call.function, type) else call.function
    names = arguments_in_module(member)[-1]
    if len(call.arguments) + len(call.options) > len(names):
        names = ["self", *names]
    yield from ((i, names[i], value) for i, value in enumerate(call.arguments))
    yield from ((name, name, value) for name, value in call.options.items())


def changed(call, place, value):
    """The result of the call with another value in one place."""
    arguments, options = list(call.arguments), dict(call.options)
    (options if isinstance(place, str) else arguments)[place] = value
    return call.function(*arguments, **options)


def test_every_function_class_and_method_is_called(calls):
    assert not set(NAMES) - set(calls)


def test_members_of_none_and_of_objects_without_init_end_no_process():
    for thing in [each for each in vars(core).values() if isinstance(each, type)]:
        for name, member in vars(thing).items():
            getter = member.fget if isinstance(member, property) else member
            for owner in (None, thing.__new__(thing)):
                if callable(getter) and name not in ("__new__", "__doc__"):
                    with contextlib.suppress(TypeError, RuntimeError, AttributeError):
                        getter(owner)


@pytest.mark.parametrize("name", NAMES)
def test_none_and_objects_without_init_in_place_of_an_argument_raise(calls, name):
    call = calls[name][0]
    for place, title, value in places(call):
        if title in OPTIONAL.get(name, ()):
            changed(call, place, None)
        elif not isinstance(value, bool):  # to a flag None is False
            with pytest.raises(TypeError):
                changed(call, place, None)
        if type(value) in vars(core).values():
            with pytest.raises((TypeError, RuntimeError)):
                changed(call, place, type(value).__new__(type(value)))


@pytest.mark.parametrize("name", NAMES)
def test_arrays_of_another_size_raise_or_are_taken_whole(calls, name):
    free = FREE.get(re.sub(r"_?float(32|64)|\.__init__", "", name, flags=re.IGNORECASE), "").split()
    for call in calls[name]:
        for place, title, array in places(call):
            for value in wrong_sizes(array) if isinstance(array, np.ndarray) else ():
                try:
                    changed(call, place, value)
                except (TypeError, ValueError, IndexError):
                    continue
                assert title in free, f"took {value.shape} for {array.shape}"
