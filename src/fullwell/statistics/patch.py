"""Mean and variance of one patch of one CFA plane, its uneven light removed (METHOD 1.1)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.tiles import polynomials


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchStatistics:
    """What a patch says.

    Parameters
    ----------
    n
        Pixels.
    dof
        n less the terms of the surface that the patch can tell apart.
    mean
        Of the patch [unit of the values].
    variance
        Sum of squares about the surface over ``dof`` [unit of the values squared]; NaN without degrees of freedom.

    """

    n: int
    dof: int
    mean: float
    variance: float


def patch_statistics(
    values: NDArray[np.uint16 | np.float32 | np.float64], *, terms: Literal[1, 3, 6] = 6
) -> PatchStatistics:
    """Return mean and variance of a patch about a polynomial surface.

    Parameters
    ----------
    values
        One plane's pixels, shape (rows, columns), none of them missing [DN].
    terms
        1: nothing but the mean is removed; 3: a plane; 6: a quadratic surface.

    Examples
    --------
    >>> ramp = np.add.outer(np.arange(3), 2 * np.arange(4)).astype(np.float64)
    >>> round(patch_statistics(ramp, terms=1).variance, 6), abs(round(patch_statistics(ramp, terms=3).variance, 6))
    (6.181818, 0.0)

    """
    rows, columns = values.shape
    n = rows * columns
    if not n:
        raise ValueError("a patch has at least one pixel")
    mean = float(values.mean(dtype=np.float64))
    residuals, removed = without_surface(values - mean, terms=terms)
    dof = n - removed
    variance = float(np.sum(residuals**2)) / dof if dof > 0 else float("nan")
    return PatchStatistics(n=n, dof=dof, mean=mean, variance=variance)


def without_surface(values: NDArray[np.floating], *, terms: Literal[1, 3, 6] = 6) -> tuple[NDArray[np.float64], int]:
    """Return values less a polynomial surface, and how many of its terms a patch of that size can tell apart.

    Parameters
    ----------
    values
        Shape (..., rows, columns); each leading index has a surface of its own.
    terms
        As in `patch_statistics`.

    """
    rows, columns = values.shape[-2:]
    degree = {1: 0, 3: 1, 6: 2}[terms]
    down, across = _basis(rows, degree), _basis(columns, degree)
    sums = down @ values @ across.T
    squares = np.outer(np.sum(down**2, axis=1), np.sum(across**2, axis=1))
    own = np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree
    own &= squares > 0.0
    shares = np.divide(sums, squares, out=np.zeros_like(sums), where=own)
    return values - down.T @ shares @ across, int(own.sum())


def _basis(length: int, degree: int) -> NDArray[np.float64]:
    """Return the orthogonal polynomials up to ``degree`` along an axis, shape (degree + 1, length)."""
    return np.stack((np.ones(length), *polynomials(np.array([length]))))[: degree + 1]
