"""A plane in bins, as lens shading is fitted to it, without defective pixels and bins near saturation (METHOD 6.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.pixel_bins import LARGEST_SIDE, SIGMAS, BinSums, Limits, bin_rows
from fullwell.statistics.pixels import PixelSums
from fullwell.statistics.tiles import edges


@dataclass(frozen=True, slots=True, kw_only=True)
class Bins:
    """Means over small squares of one plane.

    Parameters
    ----------
    size
        Edge of a bin [pixel of the plane]; the last row and column of bins may be smaller.
    n
        Pixels that count in each bin, shape (bin rows, bin columns); 0 where the bin is left out.
    mean
        Mean over these pixels and the frames, of the same shape [DN]; NaN where n is 0.
    rows, columns
        Centres of the bins along each axis [pixel of the plane, the first pixel's centre at 0].
    plane_shape
        Rows and columns of the plane [pixel].
    defective
        Pixels left out because they are far from the others of their bin, where that is not left out whole.
    saturated
        Bins left out because a pixel is too near to saturation.

    """

    size: int
    n: NDArray[np.int64]
    mean: NDArray[np.float64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    plane_shape: tuple[int, int]
    defective: int
    saturated: int


def bin_size(plane_shape: tuple[int, int]) -> int:
    """Return the edge of bins of which a plane holds about 190 x 250, at least 4 [pixel].

    Examples
    --------
    >>> bin_size((1512, 2016)), bin_size((100, 100))
    (8, 4)

    """
    rows, columns = plane_shape
    return max(4, round(float(np.sqrt(rows * columns / (190 * 250)))))


def bin_plane(
    sums_plane: PixelSums,
    frames: int,
    *,
    size: int,
    temporal_noise_dn: float,
    limit_dn: float | None,
) -> Bins:
    """Return the bins of one plane of a burst.

    A pixel is defective that lies more than 6 sigma from the median of its bin, sigma being the larger of 1.4826 times
    the median absolute deviation and the temporal noise; the others are asked again until all agree.

    Parameters
    ----------
    sums_plane
        Sum over frames of each pixel of the plane, of any strides [DN].
    frames
        How many.
    size
        Edge of a bin, at most 64 [pixel].
    temporal_noise_dn
        Temporal noise that is left in the mean of a pixel over these frames, sigma / sqrt(frames) [DN].
    limit_dn
        A bin in which the mean of a sound pixel is above is left out whole [DN]; None: none is.

    Examples
    --------
    >>> sums = np.full((8, 12), 2500, np.uint32)
    >>> sums[1, 2] = 4000
    >>> found = bin_plane(sums, 5, size=4, temporal_noise_dn=2.0, limit_dn=1000.0)
    >>> found.n.tolist(), float(found.mean[0, 0]), found.defective
    ([[15, 16, 16], [16, 16, 16]], 500.0, 1)

    """
    if not 1 <= size <= LARGEST_SIDE:
        raise ValueError(f"a bin has an edge of 1 to {LARGEST_SIDE} pixels, not {size}")
    heights, widths = (edges(length, size) for length in sums_plane.shape)
    grid = heights.size, widths.size
    n, defective = np.zeros((2, *grid), np.int64)
    found = BinSums(n, np.zeros(grid, np.uint64), defective, np.zeros(grid, np.bool_))
    plane = sums_plane.view()
    plane.flags.writeable = False
    reach, most = SIGMAS * temporal_noise_dn * frames, np.inf if limit_dn is None else limit_dn * frames
    limits = Limits(float(reach), float(most))
    bin_rows(plane, size, (0, heights.size), limits, found)
    rows, columns = sums_plane.shape
    return Bins(
        size=size,
        n=found.n,
        mean=np.divide(found.totals, found.n * frames, out=np.full(grid, np.nan), where=found.n > 0),
        rows=np.cumsum(heights) - (heights + 1) / 2,
        columns=np.cumsum(widths) - (widths + 1) / 2,
        plane_shape=(rows, columns),
        defective=int(found.defective.sum()),
        saturated=int(found.saturated.sum()),
    )
