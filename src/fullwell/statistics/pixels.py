"""Maps of one value per pixel, each a fixed linear combination of bursts: differences, slopes, intercepts."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.pixel_maps import Rows, add_four, add_one

PixelSums = NDArray[np.uint16 | np.uint32]
"""Sum over the frames of a burst of each pixel, as narrow as it fits [DN]."""

_BLOCK_BYTES: Final = 1 << 21
"""Of the rows added up at once: they stay in the second-level cache."""


def combine(
    sums: Sequence[Rows],
    coefficients: NDArray[np.float64],
    *,
    cell: int,
    workers: int = 1,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Return linear combinations of burst sums.

    Each is added up in double precision and rounded to float32 at the end.

    Parameters
    ----------
    sums
        K maps of shape (height, width): sum over the frames of each burst, or any other map [DN].
    coefficients
        Shape (maps to make, K, sites): by the site of the colour filter array, row by row.
    cell
        Period of the mosaic; ``sites`` is its square [pixel].
    workers
        Threads; the maps do not depend on their number.
    out
        Memory for the maps, to be used again; None takes new memory.

    Returns
    -------
    ndarray
        Shape (maps to make, height, width).

    Examples
    --------
    >>> bright, dark = np.full((2, 2), 500, np.uint32), np.full((2, 2), 80, np.uint32)
    >>> combine([bright, dark], np.array([[[1 / 5], [-1 / 4]]]), cell=1)
    array([[[80., 80.],
            [80., 80.]]], dtype=float32)

    """
    made, count, sites = coefficients.shape
    if not sums or count != len(sums) or sites != cell**2:
        raise ValueError(f"{len(sums)} maps of {cell**2} sites cannot take coefficients of shape {coefficients.shape}")
    plan = _Plan(
        maps=tuple(_plain(one) for one in sums),
        coefficients=np.ascontiguousarray(coefficients, np.float64).reshape(made, count, cell, cell),
    )
    height, width = sums[0].shape
    found = np.empty((made, height, width), np.float32) if out is None else out
    edges = [height * k // workers for k in range(workers + 1)]
    if workers == 1:
        plan.write(0, height, found)
        return found
    with ThreadPoolExecutor(workers) as pool:
        for part in [pool.submit(plan.write, *rows, found) for rows in pairwise(edges)]:
            part.result()
    return found


def line_coefficients(exposures_s: Sequence[float], weights: Sequence[float] | None = None) -> NDArray[np.float64]:
    """Return slope and intercept of the least-squares line as linear combinations of the means (METHOD 5.2).

    Parameters
    ----------
    exposures_s
        K exposure times, not all the same [s].
    weights
        Inverse variance of each mean, up to a common factor; None: all the same.

    Returns
    -------
    ndarray
        Shape (2, K): coefficients of the slope [1/s] and of the intercept [1].

    Raises
    ------
    ValueError
        If the exposure times do not differ.

    Examples
    --------
    >>> line_coefficients([0.0, 1.0, 2.0])
    array([[-0.5       ,  0.        ,  0.5       ],
           [ 0.83333333,  0.33333333, -0.16666667]])

    """
    t = np.asarray(exposures_s, np.float64)
    share = np.ones_like(t) if weights is None else np.asarray(weights, np.float64)
    share = share / share.sum()
    if not np.ptp(t) > 0.0:
        raise ValueError("a line needs two exposure times that differ")
    centre = float(share @ t)
    moment = float(share @ (t - centre) ** 2)
    slope = share * (t - centre) / moment
    return np.stack((slope, share - centre * slope))


def response_maps(
    means: Sequence[NDArray[np.float32]] | NDArray[np.float32],
    exposures_s: Sequence[float],
    *,
    weights: Sequence[float] | None = None,
    workers: int = 1,
    out: NDArray[np.float32] | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return slope and intercept of each pixel's line of mean against exposure time (METHOD 5.2).

    Parameters
    ----------
    means
        K maps of shape (height, width) [DN].
    exposures_s, weights
        As `line_coefficients`.
    workers
        Threads; the maps do not depend on their number.
    out
        Memory for both maps, shape (2, height, width), to be used again; None takes new memory.

    Returns
    -------
    tuple
        Slope [DN/s] and intercept [DN], each of shape (height, width).

    Examples
    --------
    >>> slope, intercept = response_maps([np.full((1, 1), mean, np.float32) for mean in (3, 5)], [1.0, 2.0])
    >>> float(slope[0, 0]), float(intercept[0, 0])
    (2.0, 1.0)

    """
    coefficients = line_coefficients(exposures_s, weights)[:, :, np.newaxis]
    slope, intercept = combine(list(means), coefficients, cell=1, workers=workers, out=out)
    return slope, intercept


def _plain(rows: Rows) -> Rows:
    """Return a read-only view in row order, so that the loops are compiled once."""
    view = np.ascontiguousarray(rows).view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, slots=True, kw_only=True)
class _Plan:
    """Which maps are combined how: coefficients (maps to make, K, cell, cell)."""

    maps: tuple[Rows, ...]
    coefficients: NDArray[np.float64]

    def write(self, top: int, bottom: int, out: NDArray[np.float32]) -> None:
        """Write some rows of the combinations."""
        made, width = out.shape[0], out.shape[2]
        cell = self.coefficients.shape[-1]
        step = max(1, _BLOCK_BYTES // (8 * made * width)) * cell
        totals = np.empty((made, step, width))
        for first in range(top, bottom, step):
            last = min(first + step, bottom)
            totals[...] = 0.0
            self._add(first, last, totals)
            out[:, first:last] = totals[:, : last - first]

    def _add(self, first: int, last: int, totals: NDArray[np.float64]) -> None:
        """Add every map, four at a time as long as there are four."""
        fours = len(self.maps) - len(self.maps) % 4
        kind = np.result_type(*self.maps)  # loops are compiled for maps of one kind
        for k in range(0, fours, 4):
            a, b, c, d = (one[first:last].astype(kind, copy=False) for one in self.maps[k : k + 4])
            add_four((a, b, c, d), first, self.coefficients[:, k : k + 4], totals)
        for k in range(fours, len(self.maps)):
            rows = self.maps[k][first:last].astype(kind, copy=False)
            add_one(rows, first, self.coefficients[:, k], totals)
