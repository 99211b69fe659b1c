"""A plane in bins, as lens shading is fitted to it, without defective pixels and bins near saturation (METHOD 6.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


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
        Centres of the bins along each axis [pixel of the plane, from 0 at the centre of the first].
    plane_shape
        Rows and columns of the plane [pixel].
    defective
        Pixels left out because they are far from the others of their bin.
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
    sums_plane: NDArray[np.uint32],
    frames: int,
    *,
    size: int,
    temporal_noise_dn: float,
    limit_dn: float | None,
    workers: int = 1,
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
    workers
        Threads; the result does not depend on their number.

    """
    raise NotImplementedError
