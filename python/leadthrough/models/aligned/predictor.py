"""Aligned demonstrations of one mode, and the curves that they predict between new ends.

Demonstrations are weighted by the nearness of their ends to the new ones. Their mean follows the
offsets of both ends as the demonstrations do: at each phase, regression on their own offsets tells
how much of an offset is left. That is the mean of a Gaussian over curves, conditioned on both ends,
whose prior covariance is a linear fade. If parts between the ends move with these in other
directions, a combination of demonstrations comes near the new ends first, and the rest fades. The
ways of weighting and fading that predict left-out demonstrations best are averaged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.curves import Curves, arc_phases, even_phases, weighted_median
from leadthrough.motion import lerp
from leadthrough.preprocess.moved_ends import ROTATED, Chords, bounded, with_ends

# Width of the weights in median distances of the ends; with the first all are as good as equal.
_WIDTHS = (1e3, 1.0, 0.4, 0.15)
_TIMED = 2.0  # of demonstrated times
# Weight of the linear fade against the demonstrations'; infinite: the linear fade alone.
_PRIORS = (0.03, 0.3, 3.0, np.inf)
# The prior of the fade after a combination, and the weight of none against the demonstrations';
# offsets of ends much below the last, in extents, are no reason to combine.
_COMBINED, _UNCOMBINED, _SMALL = 0.3, 0.015, 0.05
# An option counts by the error that it stays below with this confidence: where that is 2 % larger
# it has 1/e of the best one's share in the mean. Shares below the last, less than all have where
# none is better, are left out.
_SURE, _SPREAD, _LEAST = 0.87, 0.02, 0.02
_COMPARED = 100  # even rows, at which a prediction is compared with the left-out curve
_MOST_LEFT_OUT = 16  # demonstrations, evenly chosen
# Ends this far from those of every demonstration, in extents, and farther than these are apart, say
# nothing about the fade: up to 0.6 of the nominal path is then rotated and scaled with its chord.
_FAR, _SIMILAR = 0.3, 0.6
_TINY, _ROUNDING = 1e-300, 1e-9
_NEGLIGIBLE = 1e-3  # offsets of ends, in extents: how smaller ones fade cannot be seen


@dataclass(frozen=True)
class Option:
    """One way of weighting demonstrations and of fading the offsets of their ends."""

    phase: int  # of the curves: 0 by arc length, 1 elastic
    width: float
    prior: float
    rotated: float = 0.0  # fraction that rotates with the chord, of a linear fade
    combined: bool = False  # whether a combination of demonstrations comes near the ends first


DEFAULT = Option(0, 1.0, np.inf, ROTATED)


@dataclass(frozen=True, eq=False)
class Predictor:
    """Aligned demonstrations of one mode, in scaled columns."""

    phased: tuple[Curves, Curves]  # by arc length, and elastically
    size: int  # number of columns of the position; the others have fades of their own
    rotating: bool  # whether positions may rotate with the chord between their ends

    @cached_property
    def options(self) -> list[Option]:
        kinds = [(np.inf, ROTATED, False)] * self.rotating
        kinds += [(prior, 0.0, False) for prior in _PRIORS] + [(_COMBINED, 0.0, True)]
        return [Option(phase, w, *kind) for phase in (0, 1) for kind in kinds for w in _WIDTHS]

    @cached_property
    def _chords(self) -> list[Chords]:
        return [Chords(each.rows[:, :, : self.size]) for each in self.phased]

    def between(
        self,
        ends: Float64Array,
        options: Sequence[Option],
        without: NDArray[np.int64] | None = None,
    ) -> dict[Option, Float64Array]:
        """For each option the rows (m, n, width) over the phase between ends (m, 2, width)."""
        found = {}
        for kind, curves in enumerate(self.phased):
            own = [each for each in options if each.phase == kind]
            widths = sorted({each.width for each in own}, reverse=True)
            weights = _weights(curves.rows[:, [0, -1]], ends, widths, without)
            kinds: dict[tuple[float, float, bool], Float64Array] = {}
            if any(each.rotated for each in own):
                adapted = self._rotated(kind, ends)
                kinds[np.inf, ROTATED, False] = np.einsum("wmk,mknd->wmnd", weights, adapted)
            if fades := dict.fromkeys(_kind(each) for each in own if not each.rotated):
                faded = self._faded(curves.rows, weights, ends, list(fades))
                kinds |= dict(zip(fades, faded, strict=True))
            for each in own:
                found[each] = kinds[_kind(each)][widths.index(each.width)]
        return found

    def _faded(
        self,
        rows: Float64Array,
        weights: Float64Array,
        ends: Float64Array,
        fades: Sequence[tuple[float, float, bool]],
    ) -> list[Float64Array]:
        """For each kind of fade the means (widths, m, n, width) of curves, with new ends."""
        means = np.einsum("wmk,knd->wmnd", weights, rows)
        progress = arc_phases(means)
        linear = np.stack([1.0 - progress, progress], axis=2)
        groups = [slice(0, self.size), slice(self.size, rows.shape[2])]
        ready = [
            _Fade(rows[:, :, each], weights, means[..., each], ends[:, :, each])
            for each in (groups if rows.shape[2] > self.size else groups[:1])
        ]
        kinds = [(prior, combined) for prior, _, combined in fades]
        made = zip(*(each.rows(linear, kinds) for each in ready), strict=True)
        return [np.concatenate(parts, axis=-1) for parts in made]

    def _rotated(self, phase: int, ends: Float64Array) -> Float64Array:
        """Curves (m, k, n, width) with new ends, partly shifted and partly rotated."""
        result = with_ends(self.phased[phase].rows, ends[:, None, :1], ends[:, None, 1:])
        position = result[..., : self.size]
        position[:] = self._chords[phase].adapted(ends[:, :, : self.size], position)
        return result

    def chosen(self) -> dict[Option, float]:
        """Shares of options in the mean: more, the surer one predicts left-out demonstrations."""
        count = len(self.phased[0].rows)
        default = self.options.index(DEFAULT) if self.rotating else self.options.index(_PLAIN)
        if count < 3:
            return {self.options[default]: 1.0}
        from scipy.special import stdtrit  # scipy.stats takes a fifth of a second to load

        out = np.unique(np.linspace(0, count - 1, min(count, _MOST_LEFT_OUT)).round().astype(int))
        phased = self.phased[0].coarse(_COMPARED), self.phased[1].coarse(_COMPARED)
        few = Predictor(phased, self.size, self.rotating)
        wanted = phased[0].rows[out]
        found = few.between(wanted[:, [0, -1]], self.options, out)
        even = _evened(np.concatenate(list(found.values()))).reshape(-1, *wanted.shape)
        missed = np.linalg.norm(even - wanted, axis=3).mean(axis=2)
        gain = missed / (missed[default].mean() + _ROUNDING)
        gain -= gain[default]
        error = gain.std(axis=1, ddof=1) / np.sqrt(len(out))
        surely = gain.mean(axis=1) + stdtrit(len(out) - 1, _SURE) * error
        shares = np.exp((surely.min() - surely) / _SPREAD)
        shares[shares < _LEAST * shares.sum()] = 0.0
        shares /= shares.sum()
        return {each: float(x) for each, x in zip(self.options, shares, strict=True) if x > 0.0}

    def predicted(
        self, shares: dict[Option, float], ends: Float64Array
    ) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Mean rows (n, width) between ends (2, width), elastic phases (n,) and times (n,)."""
        timed = [replace(each, phase=1) for each in shares]
        every = self.between(ends[None], [*shares, *timed])
        weighting = np.array(list(shares.values()))
        rows = _mean(weighting, _evened(np.concatenate([every[each] for each in shares])))
        rows[[0, -1]] = ends
        aligned, even = self.phased[1], even_phases(len(rows))
        elastic = _mean(weighting, np.concatenate([every[each] for each in timed]))
        phases = np.interp(even, arc_phases(elastic), even)
        ((weights,),) = _weights(aligned.rows[:, [0, -1]], ends[None], [_TIMED], None)
        clock = np.maximum.accumulate(np.interp(phases, even, weights @ aligned.times))
        # The median, as the mean follows one that was slow.
        duration = weighted_median(aligned.times[:, -1], weights)
        return rows, phases, clock * (duration / clock[-1])

    def similar(self, rows: Float64Array, nominal: Float64Array) -> Float64Array:
        """Rows (n, width) with more of the nominal shape the farther their ends are from all."""
        ends = rows[[0, -1], : self.size]
        beyond = float(self._distances(ends[None]).min()) - max(_FAR, self._apart)
        part = _SIMILAR * float(np.clip(beyond / (1.0 - _FAR), 0.0, 1.0))
        if part == 0.0 or not self.rotating:
            return rows
        chords = Chords(nominal[None, :, : self.size])
        position = chords.adapted(ends[None], rows[None, None, :, : self.size], part)[0, 0]
        return np.hstack([position, rows[:, self.size :]])

    def _distances(self, ends: Float64Array) -> Float64Array:
        """Distances (m, k) of ends (m, 2, d) from those of each demonstration."""
        demonstrated = self.phased[0].rows[:, [0, -1], : self.size]
        return np.asarray(np.linalg.norm(demonstrated - ends[:, None], axis=3).max(axis=2))

    @cached_property
    def _apart(self) -> float:
        """Distance of the ends of a demonstration from the nearest other ones, at most."""
        distances = self._distances(self.phased[0].rows[:, [0, -1], : self.size])
        np.fill_diagonal(distances, np.inf)
        return float(distances.min(axis=1).max()) if len(distances) > 1 else 0.0

    def near(self, rows: Float64Array, nominal: Float64Array) -> Float64Array:
        """Rows (n, width), drawn to nominal ones until none moves much farther than the ends."""
        off = (rows - nominal)[[0, -1]]
        moved = [float(np.linalg.norm(part, axis=1).max()) for part in (off[:, : self.size], off)]
        parts = [
            bounded(rows[:, part], nominal[:, part], most)
            for part, most in zip((slice(0, self.size), slice(self.size, None)), moved, strict=True)
        ]
        return np.hstack(parts)


_PLAIN = Option(0, 1.0, np.inf)


def _kind(option: Option) -> tuple[float, float, bool]:
    return option.prior, option.rotated, option.combined


def _mean(shares: Float64Array, rows: Float64Array) -> Float64Array:
    return np.asarray(np.tensordot(shares, rows, 1))


def _evened(rows: Float64Array) -> Float64Array:
    """Curves (m, n, width) at even steps of their lengths."""
    even, apart = even_phases(rows.shape[1]), 2.0 * np.arange(len(rows))[:, None]
    at, known = (even + apart).ravel(), (arc_phases(rows) + apart).ravel()
    return lerp(at, known, rows.reshape(-1, rows.shape[2])).reshape(rows.shape)


def _weights(
    demonstrated: Float64Array,
    ends: Float64Array,
    widths: Sequence[float],
    without: NDArray[np.int64] | None,
) -> Float64Array:
    """Weights (widths, m, k) of demonstrations by the nearness of their ends; sum 1."""
    squared = ((ends[:, None] - demonstrated) ** 2).sum(axis=(2, 3))
    if without is not None:
        squared[np.arange(len(ends)), without] = np.inf
    ranked = np.sort(squared, axis=1)
    kept = squared.shape[1] - (without is not None)
    wide = 2.0 * np.square(widths)[:, None, None] * ranked[:, kept // 2, None] + _TINY
    weights = np.exp(-(squared - ranked[:, :1]) / wide)
    return np.asarray(weights / weights.sum(axis=2, keepdims=True))


class _Fade:
    """Regression of curves (k, n, d) on their ends, around means (widths, m, n, d)."""

    def __init__(
        self, rows: Float64Array, weights: Float64Array, means: Float64Array, ends: Float64Array
    ) -> None:
        self._rows, self._weights = rows, weights
        self._means, self._offsets = means, ends - means[:, :, [0, -1]]
        self._off = off = rows[:, [0, -1]] - means[:, :, None, [0, -1]]
        self._gram = np.einsum("wmk,wmkid,wmkjd->wmij", weights, off, off)
        # The mean's own part of the product vanishes, as the offsets' mean does.
        self._seen = np.einsum("wmk,wmkid,knd->wmin", weights, off, rows)
        variance = np.trace(self._gram, axis1=2, axis2=3) / rows.shape[2]
        self._variance = np.maximum(variance, _NEGLIGIBLE**2)[..., None, None]

    def rows(
        self, linear: Float64Array, kinds: Sequence[tuple[float, bool]]
    ) -> Iterator[Float64Array]:
        """For each prior, combined or not, the rows (widths, m, n, d) with the ends asked for.

        The fades `linear` are (widths, m, 2, n).
        """
        left = self._left(linear, sorted({prior for prior, _ in kinds}))
        for prior, combined in kinds:
            made, offsets = self._means, self._offsets
            if combined:
                shares = self._shares()
                made = made + np.einsum("wmk,knd->wmnd", shares, self._rows)
                offsets = offsets - np.einsum("wmk,wmkid->wmid", shares, self._off)
            yield np.asarray(made + left[prior].swapaxes(2, 3) @ offsets)

    def _left(self, linear: Float64Array, priors: Sequence[float]) -> dict[float, Float64Array]:
        """The fades (widths, m, 2, n) by each prior."""
        finite = [prior for prior in priors if np.isfinite(prior)]
        pull = np.reshape(finite, (-1, 1, 1, 1, 1)) * self._variance
        left = np.linalg.solve(self._gram + pull * np.eye(2), self._seen + pull * linear)
        left[..., [0, -1]] = np.eye(2)
        return {np.inf: linear, **dict(zip(finite, left, strict=True))}

    def _shares(self) -> Float64Array:
        """Shares (widths, m, k), of sum 0, in a combination that comes near the ends asked for."""
        off = self._off.reshape(*self._weights.shape, -1)
        weighted = self._weights[..., None] * off
        pull = _UNCOMBINED * self._variance + _SMALL**2
        gram = weighted.swapaxes(2, 3) @ off + pull * np.eye(off.shape[3])
        asked = self._offsets.reshape(*off.shape[:2], -1, 1)
        return np.asarray((weighted @ np.linalg.solve(gram, asked))[..., 0])
