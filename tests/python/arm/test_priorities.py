"""Strict priorities against pseudo-inverses and SciPy's bounded least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from leadthrough.arm import resolve
from leadthrough.errors import InvalidInput

SCHEMES = ("siciliano-slotine", "reverse")


def by_pseudo_inverses(jacobians, wanted):
    joints = jacobians[0].shape[1]
    motion, projector = np.zeros(joints), np.eye(joints)
    for jacobian, goal in zip(jacobians, wanted, strict=True):
        inverse = np.linalg.pinv(jacobian @ projector, rcond=1e-10)
        motion = motion + inverse @ (goal - jacobian @ motion)
        projector = projector - inverse @ (jacobian @ projector)
    return motion


def test_regular_stacks_agree_with_siciliano_and_slotines_pseudo_inverses():
    rng = np.random.default_rng(1)
    for _ in range(200):
        jacobians = [rng.normal(size=(rows, 9)) for rows in (3, 2, 3)]
        wanted = [rng.normal(size=len(jacobian)) for jacobian in jacobians]
        if np.linalg.svd(np.vstack(jacobians), compute_uv=False)[-1] < 0.5:
            continue  # near-singular stacks are damped
        truth = by_pseudo_inverses(jacobians, wanted)
        for scheme in SCHEMES:
            motion = resolve(jacobians, wanted, scheme=scheme)
            np.testing.assert_allclose(motion, truth, atol=1e-9 * (1 + np.abs(truth).max()))


def test_reverse_agrees_with_flacco_and_de_lucas_formula_on_independent_tasks():
    rng = np.random.default_rng(2)
    for _ in range(100):
        jacobians = [rng.normal(size=(2, 9)) for _ in range(3)]
        wanted = [rng.normal(size=2) for _ in range(3)]
        motion = np.zeros(9)
        for k in (2, 1, 0):
            # The columns of the augmented pseudo-inverse that leave the lower tasks in peace.
            free = np.linalg.pinv(np.vstack(jacobians[k:]))[:, :2]
            correction = np.linalg.pinv(jacobians[k] @ free) @ (wanted[k] - jacobians[k] @ motion)
            motion = motion + free @ correction
        found = resolve(jacobians, wanted, scheme="reverse")
        for jacobian in jacobians:
            np.testing.assert_allclose(jacobian @ found, jacobian @ motion, atol=1e-8)


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1), st.sampled_from(SCHEMES), st.booleans())
def test_a_lower_task_never_disturbs_a_higher_one(seed, scheme, bounded):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(3, 17))
    jacobians = []
    for _ in range(int(rng.integers(2, 7))):
        rows = int(rng.integers(1, 7))
        rank = int(rng.integers(0, rows + 1))
        jacobians.append(rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, joints)))
    jacobians[-1][0] = jacobians[0][0] + 10.0 ** rng.uniform(-15, 0) * rng.normal(size=joints)
    wanted = [rng.normal(size=len(jacobian)) for jacobian in jacobians]
    box = {"lower": -rng.random(joints), "upper": rng.random(joints)} if bounded else {}
    change = resolve(jacobians, wanted, scheme=scheme, **box) - resolve(
        jacobians[:-1], wanted[:-1], scheme=scheme, **box
    )
    for jacobian in jacobians[:-1]:
        assert np.abs(jacobian @ change).max() < 1e-9


def test_bounded_stacks_are_lexicographic_least_squares():
    rng = np.random.default_rng(3)
    for _ in range(100):
        upper = rng.uniform(0.2, 1.0, 7)
        inside = rng.uniform(-0.8, 0.8, 7) * upper
        first = rng.normal(size=(3, 7))
        second = rng.normal(size=(2, 7))
        aims = first @ inside, 0.7 * second @ inside + 0.3 * rng.normal(size=2)
        motion = resolve([first, second], aims, lower=-upper, upper=upper)
        np.testing.assert_allclose(first @ motion, aims[0], atol=1e-5)  # it fits the box
        # The second task's least squares with the first as an all but exact equation.
        weight = 1e4
        truth = lsq_linear(
            np.vstack([weight * first, second]),
            np.concatenate([weight * aims[0], aims[1]]),
            bounds=(-upper, upper),
            method="bvls",
        ).x
        ours, best = (np.linalg.norm(second @ x - aims[1]) for x in (motion, truth))
        assert ours <= 1.05 * best + 1e-5  # what cannot be met is damped by a little


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: resolve([], []), "jacobians"),
        (lambda: resolve([np.ones((1, 17))], [[1.0]]), "jacobians"),
        (lambda: resolve([np.ones((1, 3)), np.ones((1, 4))], [[1.0], [1.0]]), "jacobians"),
        (lambda: resolve([np.ones((1, 3))], [[1.0, 2.0]]), "wanted"),
        (lambda: resolve([np.ones((1, 3))], [[1.0]], lower=[1.0] * 3, upper=[0.0] * 3), "lower"),
    ],
)
def test_priorities_that_make_no_sense_are_refused(call, name):
    with pytest.raises(InvalidInput, match=name):
        call()
