"""What the Pixel study asks of single frames: exact products of two, and the spread of one after correction."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

_CHUNK: Final = 1 << 18
"""Pixels worked on at once."""
_MULTIPLIED: Final = 1 << 15
"""Pixels multiplied at once: they stay in the cache, and sums of so many products are exact in float64."""


def frame_products(mosaics: Sequence[NDArray[np.uint16]]) -> tuple[tuple[int, ...], ...]:
    """Return the exact sum over pixels of the product of each two frames.

    Parameters
    ----------
    mosaics
        L frames of one size [DN].

    Returns
    -------
    tuple
        L x L integers [DN^2].

    Examples
    --------
    >>> frame_products([np.array([[1, 2]], np.uint16), np.array([[3, 4]], np.uint16)])
    ((5, 11), (11, 25))

    """
    flat = [mosaic.reshape(-1) for mosaic in mosaics]
    totals = [[0] * len(flat) for _ in flat]
    for start in range(0, flat[0].size, _MULTIPLIED):
        part = np.stack([frame[start : start + _MULTIPLIED] for frame in flat]).astype(np.float64)
        for row, products in zip(totals, part @ part.T, strict=True):
            for index, product in enumerate(products):
                row[index] += int(product)
    return tuple(tuple(row) for row in totals)


def corrected_std(
    mosaic: NDArray[np.uint16], shading: NDArray[np.float64], *, black_dn: Sequence[float] | None = None
) -> float:
    """Return std2(double(img) ./ map): the standard deviation over the whole mosaic, colours mixed (METHOD 5.3).

    Parameters
    ----------
    mosaic
        One frame, shape (height, width) [DN].
    shading
        The whole map, same shape [1].
    black_dn
        Black level of each CFA site, row-major, for the variant that subtracts it; None leaves the pedestal in, as
        published [DN].

    Returns
    -------
    float
        Divisor n - 1 [DN].

    """
    height, width = mosaic.shape
    period = 1 if black_dn is None or len(black_dn) == 1 else 2
    step = max(period, _CHUNK // width // period * period)
    near = float(mosaic[: min(height, step)].mean())
    sums: list[float] = []
    squares: list[float] = []
    for first in range(0, height, step):
        block = mosaic[first : first + step].astype(np.float64)
        for site, black in enumerate(black_dn or ()):
            block[site // period :: period, site % period :: period] -= black
        block /= shading[first : first + step]
        block -= near
        sums.append(float(block.sum()))
        squares.append(float(np.square(block).sum()))
    total = math.fsum(sums)
    return math.sqrt((math.fsum(squares) - total**2 / mosaic.size) / (mosaic.size - 1))
