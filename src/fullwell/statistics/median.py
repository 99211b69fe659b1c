"""The exact median over pixels of the variance over frames, without a map of it (METHOD 3.6)."""

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

    def median(self, maps: Maps, site: tuple[int, int, int]) -> float:
        """Return the exact median of D; the maps are read again only where a bin is wider than one.

        Parameters
        ----------
        maps
            What was counted.
        site
            Row and column within the cell, and the cell's size.

        """
        below = np.concatenate(([0], np.cumsum(self.counts)))
        n = int(below[-1])
        ranks = np.array([(n - 1) // 2, n // 2])
        bins = np.searchsorted(below, ranks, side="right") - 1
        last = self.counts.size - 1
        if self.shift == 0 and bins[1] < last:
            return float(bins.sum()) / 2
        first_bin, last_bin = int(bins[0]), int(bins[1])
        least = first_bin << self.shift
        beyond = _BEYOND if last_bin == last else (last_bin + 1) << self.shift
        at = ranks - below[first_bin]
        picked = np.partition(pick_spreads(maps, site, least, beyond), at)[at]
        return (int(picked[0]) + int(picked[1])) / 2
