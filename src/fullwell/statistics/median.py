"""The exact median over pixels of the variance over frames, without a map of it (METHOD 3.6)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import Maps, pick_spreads

BINS: Final = 1 << 16
_SAMPLED_ROWS: Final = 16
_BEYOND: Final = (1 << 63) - 1


def shift_for(maps: Maps) -> int:
    """Return the width of bins, as a power of two, that leaves the median well inside the histogram of D.

    A guess from a few rows: a poor one costs time, not exactness.
    """
    height = maps.codes.shape[0]
    rows = np.unique(np.linspace(0, height - 1, min(height, _SAMPLED_ROWS)).astype(np.int64))
    codes = maps.codes[rows].astype(np.uint64)
    guess = int(np.quantile(np.uint64(maps.frames) * maps.squares[rows] - codes * codes, 0.75))
    return max(0, (2 * guess // BINS).bit_length())


@dataclass(frozen=True, slots=True, kw_only=True)
class SpreadHistogram:
    """Counts of D = L Q - S^2 over the pixels of one plane.

    Parameters
    ----------
    counts
        Shape (bins,); the last bin is open.
    shift
        Width of a bin is 2^shift.

    """

    counts: NDArray[np.int64]
    shift: int

    @property
    def bounds(self) -> tuple[int, int]:
        """Return the least D of the bins that hold the middle pixels, and the D beyond these."""
        first, last = (int(at) for at in self._middle[1])
        return first << self.shift, _BEYOND if last == self.counts.size - 1 else (last + 1) << self.shift

    @property
    def told(self) -> float | None:
        """Return the median of D where the counts alone tell it: bins are one wide."""
        bins = self._middle[1]
        return float(bins.sum()) / 2 if self.shift == 0 and bins[1] < self.counts.size - 1 else None

    def median(self, picked: NDArray[np.uint64]) -> float:
        """Return the exact median of D from every D within the bounds."""
        ranks, bins, below = self._middle
        at = ranks - below[bins[0]]
        middle = np.partition(picked, at)[at]
        return (int(middle[0]) + int(middle[1])) / 2

    @property
    def _middle(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Return the ranks of the two middle pixels, their bins, and how many pixels lie below each bin."""
        below = np.concatenate(([0], np.cumsum(self.counts)))
        n = int(below[-1])
        ranks = np.array([(n - 1) // 2, n // 2])
        return ranks, np.searchsorted(below, ranks, side="right") - 1, below


def medians(histograms: Sequence[SpreadHistogram], maps: Maps, phase: int) -> list[float]:
    """Return the exact medians of D of the planes of one phase of the row.

    Parameters
    ----------
    histograms
        Of each plane.
    maps
        What was counted; they are read again only where a bin is wider than one.
    phase
        Of the row within the cell.

    """
    told = [one.told for one in histograms]
    exact = [one for one in told if one is not None]
    if len(exact) == len(told):
        return exact
    picked, n = pick_spreads(maps, phase, np.array([one.bounds for one in histograms], np.uint64))
    return [one.median(own[:count]) for one, own, count in zip(histograms, picked, n, strict=True)]
