"""What rounding to integer codes does to a variance (METHOD 3.3).

Rounding adds q^2/12 only where the noise, or the spread of levels over the pixels, covers several codes. Use
`rounded_variance` where the levels of the pixels cover all phases of a code, `rounded_variance_at_phase` for one level.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

SMALL: Final = 0.1
"""Noise in codes below which the closed form holds to 1e-11 and above which ten terms of the series do."""

_LARGE: Final = 1.0
"""Noise in codes above which the series is lost in the last digit."""

_LEAST: Final = 1e-3
"""Noise in codes that any less counts as in the mean of rounded codes, whose series would have no end."""

_TERMS: Final = np.arange(1, 11, dtype=np.float64)


def quantization_variance(step: float = 1.0) -> float:
    """Return q^2/12, the variance of uniform rounding [DN^2]."""
    return step * step / 12.0


def rounded_variance(noise: float, *, step: float = 1.0) -> float:
    """Return the expected variance of rounded Gaussian noise, averaged over all phases of a code (METHOD 3.3).

    Parameters
    ----------
    noise
        Standard deviation before rounding [DN].
    step
        Distance of two codes q [DN].

    Returns
    -------
    float
        sigma^2 + q^2/12 - sum over k of q^2/(2 pi^2 k^2) exp(-4 pi^2 k^2 sigma^2/q^2) [DN^2].

    Examples
    --------
    >>> round(rounded_variance(1.0), 6)
    1.083333
    >>> rounded_variance(0.0)
    0.0

    """
    relative = noise / step
    if relative < SMALL:
        return step * noise / math.sqrt(math.pi)
    if relative > _LARGE:
        return noise**2 + step**2 * (1.0 / 12.0)
    damped = np.exp(-4.0 * np.pi**2 * _TERMS**2 * relative**2) / (2.0 * np.pi**2 * _TERMS**2)
    return noise**2 + step**2 * (1.0 / 12.0 - float(damped.sum()))


def rounded_variance_slope(noise: float, *, step: float = 1.0) -> float:
    """Return the derivative of `rounded_variance` with respect to the squared noise [1]; noise above zero."""
    relative = noise / step
    if relative < SMALL:
        return 1.0 / (2.0 * math.sqrt(math.pi) * relative)
    if relative > _LARGE:
        return 1.0
    return 1.0 + 2.0 * float(np.exp(-4.0 * np.pi**2 * _TERMS**2 * relative**2).sum())


def rounded_pattern(spread: ArrayLike, *, noise: float, step: float = 1.0) -> NDArray[np.float64]:
    """Return the expected variance over pixels of the means of their rounded codes, averaged over all phases of a code.

    Parameters
    ----------
    spread
        Standard deviation of the pixels' levels before rounding [DN].
    noise
        Standard deviation of a pixel's noise before rounding [DN].
    step
        Distance of two codes q [DN].

    Returns
    -------
    ndarray
        s^2 + sum over k of q^2/(2 pi^2 k^2) exp(-4 pi^2 k^2 sigma^2/q^2) (1 - exp(-4 pi^2 k^2 s^2/q^2)) [DN^2].

    Examples
    --------
    >>> [round(float(rounded_pattern(0.2, noise=noise)), 4) for noise in (1.0, 0.2, 0.05)]
    [0.04, 0.0483, 0.0881]

    """
    relative = np.asarray(spread, np.float64)[..., np.newaxis] / step
    terms, own = _harmonics(noise / step)
    damped = np.expm1(-4.0 * np.pi**2 * terms**2 * relative**2)
    return step**2 * (relative[..., 0] ** 2 - damped @ (own**2 / 2.0))


def rounded_pattern_at_phase(
    spread: ArrayLike, phase: ArrayLike, *, noise: float, step: float = 1.0
) -> NDArray[np.float64]:
    """Return the expected variance over pixels of the means of their rounded codes about a known level.

    The mean code of a level x is x + h(x), h a sum of sines of period q: where all pixels lie near a code, noise
    smaller than a code leaves little of their pattern, and near the edge between two it leaves too much.

    Parameters
    ----------
    spread, noise, step
        As `rounded_pattern`.
    phase
        Mean level, relative to the nearest code [DN]; broadcasts with ``spread``.

    """
    terms, own = _harmonics(noise / step)
    relative, level = (np.asarray(one, np.float64)[..., np.newaxis] / step for one in (spread, phase))
    waves = np.arange(2 * terms.size + 1, dtype=np.float64)
    left, turn = np.exp(-2.0 * np.pi**2 * waves**2 * relative**2), 2.0 * np.pi * waves * level
    single = slice(1, terms.size + 1)
    mean = (left[..., single] * np.sin(turn[..., single])) @ own
    along = (relative**2 * left[..., single] * np.cos(turn[..., single])) @ (4.0 * np.pi * terms * own)
    square = (left * np.cos(turn)) @ _products(own)
    return step**2 * (relative[..., 0] ** 2 + along + square - mean**2)


def _products(own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the amplitudes of the cosines in a sum of sines squared, of none, one, two ... periods a code."""
    product = np.zeros(2 * own.size + 1)
    product[0] = own @ own / 2.0
    product[1 : own.size] = np.correlate(own, own, "full")[own.size :]
    product[2:] -= np.convolve(own, own) / 2.0
    return product


def _harmonics(relative_noise: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the numbers and amplitudes of the sines by which the mean of rounded codes departs from the level [code].

    The first that is left out is below 1e-13.
    """
    noise = max(relative_noise, _LEAST)
    terms = np.arange(1.0, 1.25 / noise + 1.0)
    signs = np.where(terms % 2.0 == 0.0, 1.0, -1.0)
    return terms, signs / (np.pi * terms) * np.exp(-2.0 * np.pi**2 * terms**2 * noise**2)


def rounded_variance_at_phase(noise: ArrayLike, phase: ArrayLike, *, step: float = 1.0) -> NDArray[np.float64]:
    """Return the expected variance of rounded Gaussian noise about a known level [DN^2].

    Parameters
    ----------
    noise
        Standard deviation before rounding, above zero [DN].
    phase
        Mean level, relative to the nearest code [DN]; broadcasts with ``noise``.
    step
        Distance of two codes q [DN].

    """
    sigma, level = np.broadcast_arrays(np.asarray(noise, np.float64) / step, np.asarray(phase, np.float64) / step)
    reach = math.ceil(8.0 * float(sigma.max(initial=0.0))) + 2
    edges = np.arange(-reach, reach + 1) - 0.5
    from scipy.special import ndtr  # noqa: PLC0415 - the simulator imports this module and needs no SciPy

    probability = np.diff(ndtr((edges - level[..., None]) / sigma[..., None]), axis=-1)
    codes = edges[:-1] + 0.5
    mean = probability @ codes
    return step**2 * (probability @ codes**2 - mean**2)
