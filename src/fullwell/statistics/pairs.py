"""What two consecutive frames tell of one plane: temporal variance and fixed pattern, apart (EMVA1288 2)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.high_pass import pair_sums
from fullwell.kernels.stack import Stack
from fullwell.statistics.high_pass import SMALLEST_PLANE, filtered_covariance
from fullwell.statistics.moments import Layout


@dataclass(frozen=True, slots=True, kw_only=True)
class PairStatistics:
    """Two frames of one plane, with divisor M·N throughout.

    Parameters
    ----------
    n
        Pixels.
    means
        Of the two frames, the first by name first [DN].
    temporal_variance
        Half the variance of the difference, (18): the difference of the means is no noise [DN^2].
    spatial_variance
        Covariance of the frames, (32), signed [DN^2].
    filtered_variance
        The same of the frames after the high-pass filter; None where nobody asked for it, or the plane is too small
        for it [DN^2].

    """

    n: int
    means: tuple[float, float]
    temporal_variance: float
    spatial_variance: float
    filtered_variance: float | None

    @property
    def mean(self) -> float:
        """Return the mean of both frames, (16) [DN]."""
        return (self.means[0] + self.means[1]) / 2.0

    @property
    def mean_difference(self) -> float:
        """Return the mean of the first less that of the second [DN]."""
        return self.means[0] - self.means[1]


class PairSums(NamedTuple):
    """What is summed up over a plane of two frames, and the extreme codes of both.

    Parameters
    ----------
    first, second
        Sums of the codes [DN].
    squares
        Sum of the squared differences [DN^2].
    products
        Sum of the products [DN^2].
    extremes
        Lowest and highest code [DN].

    """

    first: int
    second: int
    squares: int
    products: int
    extremes: tuple[int, int]


def pair_of(
    first: NDArray[np.uint16], second: NDArray[np.uint16], *, sums: PairSums | None = None, filtered: bool = True
) -> PairStatistics:
    """Return what two frames of a plane tell; ``sums`` are theirs, where these are known already.

    Examples
    --------
    >>> first = np.array([[10, 12, 11], [13, 10, 10]], np.uint16)
    >>> pair = pair_of(first, np.array([[11, 13, 11], [13, 12, 12]], np.uint16))
    >>> pair.means, round(pair.temporal_variance, 12), round(pair.spatial_variance, 12)
    ((11.0, 12.0), 0.333333333333, 0.666666666667)

    """
    known = sums or _sums_of(np.ascontiguousarray(first), np.ascontiguousarray(second))
    fits = filtered and min(first.shape) >= SMALLEST_PLANE
    return pair_of_sums(
        known, first.size, filtered_covariance(first, second, extremes=known.extremes) if fits else None
    )


def pair_of_sums(known: PairSums, n: int, filtered_variance: float | None) -> PairStatistics:
    """Return what two frames of a plane of n pixels tell whose sums, and covariance after the filter, are known."""
    return PairStatistics(
        n=n,
        means=(known.first / n, known.second / n),
        temporal_variance=(known.squares * n - (known.first - known.second) ** 2) / (2 * n * n),
        spatial_variance=(known.products * n - known.first * known.second) / (n * n),
        filtered_variance=filtered_variance,
    )


def _sums_of(first: NDArray[np.uint16], second: NDArray[np.uint16]) -> PairSums:
    sums = np.zeros(4, np.int64)
    pair_sums(first, second, sums)
    lowest, highest = min(first.min(), second.min()), max(first.max(), second.max())
    return PairSums(*sums.tolist(), extremes=(int(lowest), int(highest)))


def pairs_of(
    stack: Stack, places: Sequence[int], layout: Layout, *, sums: Sequence[PairSums] = (), filtered: bool = True
) -> tuple[PairStatistics, ...]:
    """Return what two frames of a stack tell of each plane.

    Parameters
    ----------
    stack
        Frames in memory.
    places
        Which two, by their place in the stack.
    layout
        Planes of the mosaic.
    sums
        Of each plane, where these are known already.
    filtered
        Whether the frames are also looked at after the high-pass filter, which takes most of the time.

    """
    pixels, shape = layout.height * layout.width, (layout.height, layout.width)
    starts = (int(stack.starts[place]) for place in places)
    first, second = (stack.codes[start : start + pixels].reshape(shape) for start in starts)
    planes = [(slice(row, None, layout.cell), slice(column, None, layout.cell)) for row, column in _sites(layout)]
    known = sums or (None,) * len(planes)
    return tuple(
        pair_of(first[own], second[own], sums=its, filtered=filtered) for own, its in zip(planes, known, strict=True)
    )


def _sites(layout: Layout) -> tuple[tuple[int, int], ...]:
    return tuple(divmod(site, layout.cell) for site in range(layout.sites))
