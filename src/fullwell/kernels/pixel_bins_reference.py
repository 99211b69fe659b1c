"""What `pixel_bins` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.pixel_bins import SIGMAS, TO_SIGMA, BinSums, Limits


def _middle(x: NDArray[np.int64]) -> int:
    """Return the lower median."""
    return int(np.sort(x)[(x.size - 1) // 2])


def _sound(x: NDArray[np.int64], least_reach: float) -> NDArray[np.int64]:
    """Leave pixels out until all agree."""
    while True:
        away = np.abs(x - _middle(x))
        kept = x[away <= max(least_reach, SIGMAS * TO_SIGMA * _middle(away))]
        if kept.size == x.size:
            return kept
        x = kept


def bin_rows(plane: NDArray[np.uint32], size: int, rows: tuple[int, int], limits: Limits, found: BinSums) -> None:
    """Write some rows of bins; see `pixel_bins.bin_rows`."""
    for row in range(*rows):
        for column in range(found.n.shape[1]):
            pixels = plane[row * size : (row + 1) * size, column * size : (column + 1) * size].astype(np.int64).ravel()
            kept = _sound(pixels, limits.least_reach)
            out = bool(kept.max() > limits.most)
            found.saturated[row, column] = out
            found.n[row, column] = 0 if out else kept.size
            found.defective[row, column] = 0 if out else pixels.size - kept.size
            found.totals[row, column] = 0 if out else kept.sum()
