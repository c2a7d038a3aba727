"""Fast marching against scikit-fmm, distance transform against edt and SciPy, on one thread."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import edt
import numpy as np
import scipy.ndimage
import skfmm
from frame import Benchmark

import leadthrough as lt
from leadthrough.planning import distance_transform

# Relative to the latest arrival time. At second order with walls the peer is no reference:
# it treats cells with inconsistent differences in another way.
TOLERANCE = {"float64": 1e-9, "float32": 1e-4, "order 2": 0.05}


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for 2-D and 3-D fields."""
    plane, cube = ((300, 300), (60, 60, 60)) if quick else ((1000, 1000), (150, 150, 150))
    for shape in (plane, cube):
        size = " x ".join(map(str, shape))
        yield from _marches(f"march {size}, constant speed", *constant_speed(shape))
        yield from _marches(f"march {size}, variable speed, walls", *variable_speed(shape))
        yield _largest_error(f"march {size}, order 2, error over the peer's", shape)
        yield from _distances(f"distances {size}", np.random.default_rng(1).random(shape) < 2e-4)


def _marches(name: str, speed: Any, source: tuple[int, ...]) -> Iterator[Benchmark]:
    for variant, options in {
        "float32": {"dtype": np.float32},
        "float64": {},
        "order 2": {"order": 2},
    }.items():
        yield Benchmark(
            name=f"{name}, {variant}",
            ours=partial(
                lt.arrival_times, speed.astype(options.get("dtype", float)), source, **options
            ),
            peer=_scikit_fmm(speed, source, options.get("order", 1)),
            peer_name="scikit-fmm",
            error=relative_error,
            tolerance=TOLERANCE[variant],
        )


def _largest_error(name: str, shape: tuple[int, ...]) -> Benchmark:
    """Our largest error over the peer's, both against the exact distance from a point source."""
    speed, source = constant_speed(shape)
    axes = np.meshgrid(
        *(np.arange(n) - s for n, s in zip(shape, source, strict=True)), indexing="ij"
    )
    truth = np.sqrt(sum(axis.astype(float) ** 2 for axis in axes))
    return Benchmark(
        name=name,
        ours=partial(lt.arrival_times, speed, source, order=2),
        peer=_scikit_fmm(speed, source, order=2),
        peer_name="scikit-fmm",
        error=lambda a, b: float(np.abs(a - truth).max() / np.abs(b - truth).max()),
        tolerance=0.25,
    )


def _distances(name: str, mask: Any) -> Iterator[Benchmark]:
    peers = {
        "edt": partial(edt.edt, ~mask, black_border=False, parallel=1),
        "SciPy": partial(scipy.ndimage.distance_transform_edt, ~mask),
    }
    for peer_name, peer in peers.items():
        ours = partial(distance_transform, mask)
        yield Benchmark(name, ours, peer, peer_name, relative_error, TOLERANCE["float32"])


def constant_speed(shape: tuple[int, ...]) -> tuple[Any, tuple[int, ...]]:
    """A map of speed 1, and its middle cell as the source."""
    return np.ones(shape), tuple(n // 2 for n in shape)


def variable_speed(shape: tuple[int, ...]) -> tuple[Any, tuple[int, ...]]:
    """A map of speeds between 0.1 and 1 with blocks of 13 cells on a lattice, and its source."""
    axes = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    waves = [np.sin(k * axis + 1) for axis, k in zip(axes, (0.13, 0.11, 0.09), strict=False)]
    blocks = sum(axis // 20 for axis in axes) % 5 == 2
    blocks &= np.all([axis % 20 > 6 for axis in axes], axis=0)
    speed = np.where(blocks, 0.0, 0.55 + 0.45 * np.prod(waves, axis=0))
    source = tuple(n // 2 for n in shape)
    speed[source] = 1.0
    return speed, source


def _scikit_fmm(speed: Any, source: tuple[int, ...], order: int) -> Callable[[], Any]:
    phi = np.ones(speed.shape)
    phi[source] = 0.0
    walls = speed == 0.0
    front = np.ma.MaskedArray(phi, walls) if walls.any() else phi
    return partial(skfmm.travel_time, front, np.where(walls, 1.0, speed), order=order)


def relative_error(ours: Any, peers: Any) -> float:
    """The largest difference over the latest time; inf if only one has reached a cell."""
    expected = np.ma.filled(peers, np.inf)
    finite = np.isfinite(expected)
    if not np.array_equal(np.isfinite(ours), finite):
        return np.inf
    return float(np.abs(ours[finite] - expected[finite]).max() / expected[finite].max())
