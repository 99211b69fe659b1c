"""Mean and noise of a histogram that a rail cuts off: a rounded, censored normal by maximum likelihood (METHOD 3.4).

Each code holds the normal's mass over its width; the lowest code of a clipped histogram holds the whole lower tail, the
highest likewise. Rounding is part of the model, so the noise comes out without quantization.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri

from fullwell.units import DN, Measured

MAX_CLIPPED: Final = 1e-3
"""Share of the pixels on the lowest code above which a variance is not to be trusted (METHOD 0)."""
_MISSING: Final = 10.0
"""Draws that must be missing below the lowest code before it counts as a rail."""
_MISSING_SHARE: Final = 2e-4
"""The same as a share of all values; less does no harm to a variance."""
_STILL: Final = 1e-10
"""Squared step, in squared standard errors, at which the likelihood stands still."""
_BODY: Final = 0.84
"""Quantile above which codes are pooled when looking for a rail, so that hot pixels do not count."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CensoredNormal:
    """A normal fitted to a histogram.

    Parameters
    ----------
    mean
        Of the noise before clipping [DN].
    noise
        Standard deviation before clipping and rounding [DN].
    converged
        Whether the likelihood stood still.

    """

    mean: Measured
    noise: Measured
    converged: bool


def fit_censored_normal(
    first_code: int, counts: NDArray[np.int64], *, clipped_low: bool, clipped_high: bool, step: int = 1
) -> CensoredNormal:
    """Fit a rounded normal whose outermost codes may hold a whole tail (METHOD 3.4).

    Parameters
    ----------
    first_code
        Code of ``counts[0]`` [DN].
    counts
        Shape (codes,).
    clipped_low, clipped_high
        Whether the first and the last code hold everything beyond them.
    step
        Distance of two codes that occur [DN]; ``counts`` holds the codes between, too.

    Returns
    -------
    CensoredNormal
        Its errors are those of the Fisher information and take every count as independent.

    Raises
    ------
    ValueError
        Where fewer than two codes are populated.

    """
    cells = np.asarray(counts, np.float64)[::step]
    if np.count_nonzero(cells) < 2:
        raise ValueError("a histogram with one populated code says nothing about the noise")
    lower = np.arange(cells.size, dtype=np.float64) - np.float64(0.5)
    upper = lower + np.float64(1.0)
    if clipped_low:
        lower[0] = -np.inf
    if clipped_high:
        upper[-1] = np.inf
    parameters, information, converged = _maximize(cells, lower, upper)
    mean_error, log_noise_error = (float(error) for error in np.sqrt(np.diagonal(np.linalg.inv(information))))
    noise = float(np.exp(parameters[1])) * step
    return CensoredNormal(
        mean=Measured.normal(first_code + step * float(parameters[0]), step * mean_error, DN),
        noise=Measured.normal(noise, noise * log_noise_error, DN),
        converged=converged,
    )


def is_clipped_low(
    first_code: int,
    counts: NDArray[np.int64],
    *,
    step: int = 1,
    suspected_rail: int | None = None,
    alike: float = 1.0,
) -> bool:
    """Return whether the lowest code is a rail: over 0.1 % of the values on it, and a tail missing below it.

    Parameters
    ----------
    first_code
        Code of ``counts[0]`` [DN].
    counts
        Shape (codes,), the first one populated.
    step
        Distance of two codes that occur [DN].
    suspected_rail
        A code that may be a rail for reasons of its own, such as a declared black level; it decides where the
        histogram cannot.
    alike
        Values that count as one: of L frames of a fixed pattern that noise hardly blurs, each pixel is one draw.

    Notes
    -----
    A narrow distribution that is not cut, noise 0.3 DN say, has many values on its lowest code as well. The two are
    told apart by what should lie below: a censored normal, which fits whether or not there is a rail, must put more
    than ten draws, and 0.02 % of all, there. That takes two more codes with over 0.1 % of the values; with fewer
    the histogram cannot tell, and only code 0 or the suspected rail counts as one.

    """
    cells = np.asarray(counts, np.int64)[::step]
    total = int(cells.sum())
    if total == 0 or cells[0] <= MAX_CLIPPED * total:
        return False
    if first_code == 0:
        return True
    if cells.size < 3 or cells[1:3].min() <= MAX_CLIPPED * total:
        return first_code == suspected_rail
    fit = _fit_body(cells)
    below = float(np.exp(log_ndtr((-0.5 - fit.mean.value) / fit.noise.value)))
    return below > max(_MISSING_SHARE, _MISSING * alike / total)


def trim_hot_pixels(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the histogram without the codes so high that the noise of its body puts no value there.

    A normal law has no room for hot pixels, and a few of them would set the noise of the whole fit. The body is all up
    to the 84 % quantile, and the lowest code may be a rail; codes are kept up to where less than 0.05 values are
    expected beyond. Where the body spans fewer than three codes nothing is cut.

    Examples
    --------
    >>> trim_hot_pixels(np.array([500, 300, 150, 40, 8, 2, 0, 0, 0, 0, 0, 0, 0, 3])).size
    7

    """
    cells = np.asarray(counts, np.int64)
    total = int(cells.sum())
    if np.count_nonzero(cells) < 3:
        return counts
    fit = _fit_body(cells)
    limit = fit.mean.value - float(ndtri(0.05 / total)) * fit.noise.value
    return counts[: max(int(np.ceil(limit)) + 1, 3)]


def _fit_body(cells: NDArray[np.int64]) -> CensoredNormal:
    """Fit the codes up to the 84 % quantile, all above pooled, the lowest as a rail."""
    body = max(int(np.searchsorted(np.cumsum(cells), _BODY * int(cells.sum()))), 2)
    pooled = np.append(cells[:body], cells[body:].sum())
    return fit_censored_normal(0, pooled, clipped_low=True, clipped_high=True)


def _maximize(
    cells: NDArray[np.float64], lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Fisher scoring on (mean, log noise), in codes from the first one; steps are halved until they climb."""
    total = float(cells.sum())
    codes = np.arange(cells.size, dtype=np.float64)
    mean = float(cells @ codes) / total
    spread = float(np.sqrt(max(cells @ (codes - mean) ** 2 / total, 0.05)))
    parameters: NDArray[np.float64] = np.array([mean, np.log(spread)], np.float64)
    likelihood, score, information = _likelihood(parameters, cells, lower, upper)
    for _ in range(200):
        step: NDArray[np.float64] = np.asarray(np.linalg.solve(information, score), np.float64)
        step /= max(1.0, abs(step[0]) / (2.0 * np.exp(parameters[1])), abs(step[1]) / 0.7)
        if float(step @ information @ step) < _STILL:
            return parameters, information, True
        factor = 1.0
        while factor > 1e-6:
            tried = parameters + factor * step
            new_likelihood, new_score, new_information = _likelihood(tried, cells, lower, upper)
            if new_likelihood >= likelihood - 1e-12 * abs(likelihood):
                break
            factor /= 2.0
        else:
            return parameters, information, True
        parameters, likelihood, score, information = tried, new_likelihood, new_score, new_information
    return parameters, information, False


def _likelihood(
    parameters: NDArray[np.float64], cells: NDArray[np.float64], lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return the log-likelihood, its gradient and the Fisher information; safe however far out a cell lies."""
    noise = np.exp(parameters[1])
    low, high = (lower - parameters[0]) / noise, (upper - parameters[0]) / noise
    log_mass = _log_normal_mass(low, high)
    density_low, density_high = (_density_over_mass(edge, log_mass) for edge in (low, high))
    by_mean = (density_low - density_high) / noise
    by_log_noise = _times(low, density_low) - _times(high, density_high)
    gradient = np.stack([by_mean, by_log_noise])
    expected = cells.sum() * np.exp(log_mass)
    return (
        float(cells @ log_mass),
        gradient @ cells,
        (gradient * expected) @ gradient.T,
    )


def _log_normal_mass(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ln(Phi(high) - Phi(low)), taken in the tail where the difference does not cancel."""
    mirrored = low > 0.0
    near = np.where(mirrored, -low, high)
    far = np.where(mirrored, -high, low)
    log_near, log_far = log_ndtr(near), log_ndtr(far)
    with np.errstate(divide="ignore"):
        return log_near + np.log1p(-np.exp(np.minimum(log_far - log_near, -1e-300)))


def _density_over_mass(edge: NDArray[np.float64], log_mass: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(over="ignore", invalid="ignore"):
        log_density = -0.5 * edge**2 - 0.5 * np.log(2.0 * np.pi)
    return np.exp(np.minimum(log_density - log_mass, 700.0))


def _times(edge: NDArray[np.float64], density: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(np.isinf(edge), 0.0, edge) * density
