"""The read noise of a typical pixel: the median over pixels, which a few telegraph pixels do not move (METHOD 3.6).

Which function: `median_pixel_noise` for the noise before rounding, `median_pixel_variance` for that of the codes.
"""

import math

from scipy.special import chdtri, gammaln

from fullwell.fit.read_noise import ReadNoise, analogue_read_noise
from fullwell.units import DN2, Measured


def median_pixel_noise(median_dn2: float, *, frames: int, pixels: int, quantization_step: float = 1.0) -> ReadNoise:
    """Return the noise before rounding of the median pixel, whose level has one phase of the code, an unknown one.

    That levels of other pixels cover all phases does not help: a mean over phases is no median over them.

    Parameters
    ----------
    median_dn2, frames, pixels, quantization_step
        As for `median_pixel_variance`.

    """
    median = median_pixel_variance(median_dn2, frames=frames, pixels=pixels, quantization_step=quantization_step)
    return analogue_read_noise(median, quantization_step=quantization_step, spatial_spread_dn=0.0)


def median_pixel_variance(median_dn2: float, *, frames: int, pixels: int, quantization_step: float = 1.0) -> Measured:
    """Return the temporal variance of the median pixel from the median over pixels of the variance over frames.

    Parameters
    ----------
    median_dn2
        Median over the pixels of the unbiased variance over ``frames`` frames [DN^2].
    frames
        L, at least two: for normal noise the median is that of chi-square with L - 1 degrees of freedom over L - 1.
    pixels
        How many.
    quantization_step
        Distance of two codes q [DN].

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
    code_dn2 = quantization_step**2
    step = _widest_step(median_dn2 * pairs / code_dn2, frames) * code_dn2
    grain = step / pairs / ratio / math.sqrt(12.0)
    return Measured.normal(value, math.hypot(sampling, grain), DN2)


def _widest_step(spread: float, frames: int) -> float:
    """Return the widest step near D = L Q - S^2 to the next D that L whole codes can have.

    Two frames give squares, three twice a Loeschian number, four three squares in a sum; more frames give all numbers
    of some remainders by 2 L, at most L - 1 apart. Of five to eight frames they come in such unequal shares that the
    median strays as if 8 apart.
    """
    if frames == 2:
        return 2.0 * math.sqrt(spread) + 1.0
    if frames == 3:
        return 5.0 * max(spread / 2.0, 1.0) ** 0.25
    return max(8.0, frames - 1.0)
