"""How the noise of neighbours hangs together: covariances of differences of two frames, by plane (METHOD 10.3).

The difference of two frames holds their temporal noise only; what rows and columns have in common is taken off first,
since line noise has figures of its own. Noise of independent pixels has no covariance at any lag but 0. A filter
leaves some, and takes as much from the variance: their sum over all lags is what the filter kept of it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

REACH: Final = 3
"""Largest lag [pixel of the plane]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseCorrelation:
    """Covariances of one plane.

    Parameters
    ----------
    covariance_dn2
        Of a single frame's noise at lags of 0 to 3 rows (first axis) and -3 to 3 columns (second axis), shape (4, 7)
        [DN^2].
    n
        Pixels.

    """

    covariance_dn2: NDArray[np.float64]
    n: int

    @property
    def variance_dn2(self) -> float:
        """Return the covariance at no lag [DN^2]."""
        return float(self.covariance_dn2[0, REACH])

    @property
    def correlation(self) -> NDArray[np.float64]:
        """Return the covariances as a share of the variance [1]."""
        return self.covariance_dn2 / self.variance_dn2

    @property
    def std_error(self) -> float:
        """Return the standard error of one correlation of independent pixels [1]."""
        return float(self.n**-0.5)

    @property
    def total_dn2(self) -> float:
        """Return the sum of the covariances over all lags, both signs [DN^2]."""
        half = self.covariance_dn2[0, REACH + 1 :].sum() + self.covariance_dn2[1:].sum()
        return float(self.variance_dn2 + 2.0 * half)


def noise_correlation(first: NDArray[np.uint16], second: NDArray[np.uint16]) -> NoiseCorrelation:
    """Return the covariances of the noise of one plane of two frames of the same light.

    Parameters
    ----------
    first, second
        Shape (rows, columns), at least 8 x 8 [DN]; the second is scaled to the mean of the first.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> one, two = (rng.normal(500.0, 4.0, (256, 256)).round().astype(np.uint16) for _ in range(2))
    >>> found = noise_correlation(one, two)
    >>> bool(abs(found.correlation[0, 4]) < 4 * found.std_error), round(found.variance_dn2)
    (True, 16)

    """
    difference, other = first.astype(np.float64), second.astype(np.float64)
    difference -= difference.mean()
    other -= other.mean()
    difference -= other
    difference -= difference.mean(axis=1, keepdims=True)
    difference -= difference.mean(axis=0, keepdims=True)
    rows, columns = difference.shape
    found = np.zeros((REACH + 1, 2 * REACH + 1))
    for down in range(REACH + 1):
        for right in range(-REACH, REACH + 1):
            left, start = max(right, 0), max(-right, 0)
            here = difference[: rows - down, start : columns - left]
            there = difference[down:, left : columns - start]
            found[down, right + REACH] = np.einsum("ij,ij->", here, there) / (2.0 * here.size)
    return NoiseCorrelation(covariance_dn2=_with_means(found, rows, columns), n=difference.size)


def _with_means(found: NDArray[np.float64], rows: int, columns: int) -> NDArray[np.float64]:
    """Put back what taking off the means of rows and columns takes from covariances of independent pixels."""
    kept_down, kept_across = np.full(REACH + 1, -1.0 / rows), np.full(2 * REACH + 1, -1.0 / columns)
    kept_down[0] += 1.0
    kept_across[REACH] += 1.0
    share = np.outer(kept_down, kept_across)
    variance = found[0, REACH] / share[0, REACH]
    whole = found - variance * share
    whole[0, REACH] = variance
    return whole
