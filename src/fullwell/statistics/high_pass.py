"""Planes without their slow variation, as EMVA 1288 Release 4.0 filters them, and what the filter does to noise.

White noise loses a little of its variance to the filter; the gains are exact, from the filter's own weights.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.filtered_products import WIDEST_RANGE, Part, add_filtered_products, nothing_passed
from fullwell.kernels.high_pass import REACH, add_products, high_pass

SMALLEST_PLANE: Final = 2 * REACH + 2
"""Rows and columns that a plane needs at least, so that some are left [pixel]."""

VARIANCE_GAIN: Final = 555977745 / 562448656
"""Variance of filtered white noise over that of the noise, of pixels."""

LINE_VARIANCE_GAIN: Final = 21085 / 23716
"""The same of a pattern of rows or columns, and of the row or column means of pixel noise."""

PIXEL_SPREAD: Final = 1.0090072**0.5
"""By how much the variance of filtered white noise scatters more than that of as many independent pixels."""

LINE_SPREAD: Final = 1.1108369**0.5
"""The same of a pattern of rows or columns."""

_BAND: Final = 128
"""Rows filtered at a time, so that they stay in the cache."""


def filtered(plane: NDArray[np.generic], *, frames: int = 1) -> NDArray[np.float64]:
    """Return a plane without its slow variation, shape (M - 18, N - 18) [DN].

    Parameters
    ----------
    plane
        Sums over ``frames`` frames, which the outcome is divided by, or any other numbers; shape (M, N) [DN].

    Raises
    ------
    ValueError
        If the plane is smaller than 20 x 20.

    """
    rows, columns = plane.shape
    if min(rows, columns) < SMALLEST_PLANE:
        raise ValueError(f"a plane of {columns} x {rows} pixels is too small for the high-pass filter")
    out = np.empty((rows - 2 * REACH, columns - 2 * REACH))
    for top in range(0, rows - 2 * REACH, _BAND):
        band = out[top : top + _BAND]
        high_pass(np.ascontiguousarray(plane[top : top + len(band) + 2 * REACH], np.float64), band)
        band /= frames
    return out


class PassingPair:
    """One plane of two frames, filtered some rows at a time and multiplied (EMVA1288 (32)).

    Parameters
    ----------
    shape
        Of the plane, at least 20 x 20 pixels.

    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self._n = (shape[0] - 2 * REACH) * (shape[1] - 2 * REACH)
        self._passed = nothing_passed(shape[1])
        self._totals = np.zeros(4, np.int64)
        self._offset = -1
        self._lowest, self._highest = 65535, 0
        self._wide = False

    def add(self, part: Part, extremes: tuple[int, int]) -> None:
        """Pass further rows, whose lowest and highest codes are known; parts follow each other from the top."""
        low, high = self._lowest, self._highest = min(self._lowest, extremes[0]), max(self._highest, extremes[1])
        if self._offset < 0:
            self._offset = max(0, (low + high) // 2 - WIDEST_RANGE // 2)
        self._wide = self._wide or low < self._offset or high - self._offset > WIDEST_RANGE
        if not self._wide:
            add_filtered_products(part, (self._offset, high - low), self._passed, self._totals)

    def covariance(self) -> float | None:
        """Return what `filtered_covariance` does once all rows have passed; None where their codes lie too far apart.

        How far depends on those of the first rows.
        """
        if self._wide:
            return None
        low, high, sum_a, sum_b = self._totals.tolist()
        return ((low + (high << 32)) * self._n - sum_a * sum_b) / (self._n * self._n * 308**4)


def filtered_covariance(first: NDArray[np.uint16], second: NDArray[np.uint16], *, extremes: tuple[int, int]) -> float:
    """Return the covariance over pixels of two frames, each filtered: temporal noise drops out (EMVA1288 (32)).

    Parameters
    ----------
    first, second
        One plane of two frames, shape (M, N) [DN].
    extremes
        Lowest and highest code of both [DN].

    Returns
    -------
    float
        Signed: half of the estimates lie below zero where there is no fixed pattern [DN^2].

    """
    rows, columns = first.shape
    n = (rows - 2 * REACH) * (columns - 2 * REACH)
    first, second = np.ascontiguousarray(first), np.ascontiguousarray(second)
    passing = PassingPair((rows, columns))
    passing.add(Part(first, second, 0, 0, rows), extremes)
    found = passing.covariance()
    if found is not None:
        return found
    products, sums = _products(first, second)
    mean_a, mean_b = sums.sum(axis=1) / n
    return float(products.sum() / n - mean_a * mean_b)


def _products(first: NDArray[np.uint16], second: NDArray[np.uint16]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return, of each column of two filtered frames, the sum of the products and the sums of both."""
    rows, columns = (side - 2 * REACH for side in first.shape)
    buffers = np.empty((2, min(_BAND, rows), columns))
    products, sums = np.zeros(columns), np.zeros((2, columns))
    for top in range(0, rows, _BAND):
        bottom = min(top + _BAND, rows)
        a, b = buffers[:, : bottom - top]
        high_pass(first[top : bottom + 2 * REACH], a)
        high_pass(second[top : bottom + 2 * REACH], b)
        add_products(a, b, products, sums)
    return products, sums
