"""What `high_pass` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.high_pass import REACH

SMOOTHER = np.convolve(np.convolve(np.ones(7), np.ones(11)), [1.0, 2.0, 1.0])
"""19 weights along one axis; their sum is 308."""


def high_pass(plane: NDArray[np.float64] | NDArray[np.uint16], out: NDArray[np.float64]) -> None:
    """Filter a plane; see `high_pass.high_pass`."""
    values = np.asarray(plane, np.float64)
    for _axis in (0, 1):
        values = np.array([np.convolve(line, SMOOTHER, "valid") for line in values]).T
    out[...] = plane[REACH:-REACH, REACH:-REACH] - values / 308.0**2


def pair_sums(first: NDArray[np.uint16], second: NDArray[np.uint16], sums: NDArray[np.int64]) -> None:
    """Add up two frames of a plane; see `high_pass.pair_sums`."""
    a, b = first.astype(np.int64), second.astype(np.int64)
    sums += [a.sum(), b.sum(), np.square(a - b).sum(), (a * b).sum()]
