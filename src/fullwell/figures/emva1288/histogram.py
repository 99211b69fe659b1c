"""Logarithmic and accumulated histograms of averaged stacks: defects stand out (EMVA1288 7.8, 7.9)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.sweep import Floats

MOST_BINS: Final = 256
_AT_ONCE: Final = 1 << 15
"""Values counted at a time, so that they stay in the cache."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StackHistogram:
    """Pixels by their value.

    Parameters
    ----------
    centres
        Of the bins [DN].
    counts
        Pixels in each.
    width
        Of a bin [DN].

    """

    centres: Floats
    counts: NDArray[np.int64]
    width: float


def stack_histogram(values: Floats, *, frames: int, about: float | None = None) -> StackHistogram:
    """Count the values of an average of ``frames`` frames, (73) to (75).

    Parameters
    ----------
    values
        Of any shape [DN].
    frames
        L: bins are a whole number of steps of 1/L wide, at most 256 of them.
    about
        What deviations are counted from in place of the values, so that the first bin begins at 0 [DN].

    Examples
    --------
    >>> found = stack_histogram(np.array([0, 0.25, 0.25, 0.5, 0.75, 1, 1, 1.25, 2, 130]), frames=4)
    >>> found.counts.size, found.centres[:2].tolist(), found.width
    (174, [0.25, 1.0], 0.75)

    """
    low, high = float(values.min()), float(values.max())
    first, last = (low, high) if about is None else (0.0, max(abs(low - about), abs(high - about)))
    span = frames * (last - first)
    step = math.floor(span / MOST_BINS) + 1
    bins = math.floor(span / step) + 1
    flat, counts = values.reshape(-1), np.zeros(bins, np.int64)
    for start in range(0, flat.size, _AT_ONCE):
        part = flat[start : start + _AT_ONCE]
        above = part - first if about is None else np.abs(part - about)
        above *= frames / step
        places = above.astype(np.int64)
        counts += np.bincount(np.minimum(places, bins - 1, out=places), minlength=bins)
    centres = first + (step - 1) / (2.0 * frames) + np.arange(bins, dtype=np.float64) * (step / frames)
    return StackHistogram(centres=centres, counts=counts, width=step / frames)


def normal_counts(histogram: StackHistogram, *, mean: float, variance: float) -> Floats:
    """Return what a normal of the same variance would have in each bin, (76)."""
    n = int(histogram.counts.sum())
    if variance <= 0.0:
        return np.zeros_like(histogram.centres)
    height = histogram.width * n / math.sqrt(2.0 * math.pi * variance)
    return height * np.exp(-((histogram.centres - mean) ** 2) / (2.0 * variance))


def accumulated(values: Floats, *, frames: int) -> StackHistogram:
    """Return how many pixels deviate from the mean as much as each bin tells or more, (77) to (81)."""
    found = stack_histogram(values, frames=frames, about=float(values.mean()))
    return StackHistogram(centres=found.centres, counts=np.cumsum(found.counts[::-1])[::-1], width=found.width)
