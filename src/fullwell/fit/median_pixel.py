"""The read noise of a typical pixel: the median over pixels, which a few telegraph pixels do not move (METHOD 3.6)."""

import math

from scipy.special import chdtri, gammaln

from fullwell.units import DN2, Measured


def median_pixel_variance(median_dn2: float, *, frames: int, pixels: int) -> Measured:
    """Return the temporal variance of the median pixel from the median over pixels of the variance over frames.

    Parameters
    ----------
    median_dn2
        Median over the pixels of the unbiased variance over ``frames`` frames [DN^2].
    frames
        L, at least two: for normal noise the median is that of chi-square with L - 1 degrees of freedom over L - 1.
    pixels
        How many.

    Returns
    -------
    Measured
        Its error is that of a sample median, and the grain of variances of whole codes as a uniform law [DN^2].

    Examples
    --------
    >>> round(median_pixel_variance(0.83917, frames=5, pixels=1_000_000).value, 3)
    1.0

    """
    dof = frames - 1
    median = float(chdtri(dof, 0.5))
    ratio = median / dof
    value = median_dn2 / ratio
    half = dof / 2.0
    density = math.exp((half - 1.0) * math.log(median) - median / 2.0 - half * math.log(2.0) - gammaln(half)) * dof
    sampling = value / ratio / (2.0 * density * math.sqrt(pixels))
    pairs = frames * dof
    grain = _widest_step(median_dn2 * pairs, frames) / pairs / ratio / math.sqrt(12.0)
    return Measured.normal(value, math.hypot(sampling, grain), DN2)


def _widest_step(spread: float, frames: int) -> float:
    """Return the widest step near D = L Q - S^2 to the next D that L whole codes can have.

    Two frames give squares, three twice a Loeschian number, four three squares in a sum; more frames give all numbers
    of some remainders by 2 L, at most L - 1 apart.
    """
    if frames == 2:
        return 2.0 * math.sqrt(spread) + 1.0
    if frames == 3:
        return 5.0 * max(spread / 2.0, 1.0) ** 0.25
    return 8.0 if frames == 4 else frames - 1.0
