"""Where the sensor saturates, by three definitions that differ (METHOD 7).

Every one is read off a grid of exposures, so each comes with the levels that bracket it; the grid, not the noise, sets
its error.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from fullwell.figures.ratios import Ratio
from fullwell.units import DN, Measured

ADC_LIMITED: Final = 0.5
"""Clipped share at the plateau above which the converter, not the pixel, is the limit."""
CONSISTENT: Final = 4.0
"""Largest |r| of a level that still follows the photon transfer curve."""

_ADC_FLAG: Final = "adc-limited"
LOWER_BOUND: Final = "lower-bound"
GRID_LIMITED: Final = "grid-limited"
_NORMAL_975: Final = 1.959963984540054


@dataclass(frozen=True, slots=True, kw_only=True)
class SaturationLevel:
    """A saturation signal above the black level.

    Parameters
    ----------
    signal
        The level; its interval is the bracket, which a lower bound has not [DN].
    flags
        ``adc-limited`` where the converter is the limit, ``lower-bound`` where the frames do not reach saturation,
        ``grid-limited`` where the interval is the bracket.

    """

    signal: Measured
    flags: tuple[str, ...]

    @property
    def bound_flags(self) -> tuple[str, ...]:
        """Those that hold for what follows from it too: a lower bound, read off a grid."""
        return tuple(flag for flag in self.flags if flag in {LOWER_BOUND, GRID_LIMITED})

    def through(self, figure: Callable[[Measured], Ratio]) -> Ratio:
        """Return a ratio that rises with the level: off a grid, its interval reaches from end to end of the bracket.

        Parameters
        ----------
        figure
            The ratio at a level; of a level without an error, with an interval of what else is uncertain.

        """
        found, ends = figure(self.signal), self.signal.ci95
        if GRID_LIMITED not in self.flags or ends is None or ends[0] <= 0.0:
            return found
        low, high = (figure(Measured.exact(end, self.signal.unit)) for end in ends)
        return found.between(low, high)


def bounded(figure: Measured, flags: Collection[str]) -> Measured:
    """Return what a row of these flags may claim: a lower bound has neither error nor interval."""
    return Measured.exact(figure.value, figure.unit) if LOWER_BOUND in flags else figure


def temporal_variance_peak(
    signal_dn: ArrayLike,
    variance_dn2: ArrayLike,
    clipped_fraction: ArrayLike,
    *,
    std_error_dn: ArrayLike = 0.0,
) -> SaturationLevel:
    """Return the signal with the largest temporal variance, with the levels that bracket the peak (METHOD 7a).

    Parameters
    ----------
    signal_dn
        Mean above the black level at each exposure, shape (N,) [DN].
    variance_dn2
        Temporal variance there [DN^2].
    clipped_fraction
        Share of values on the highest code there [1].
    std_error_dn
        Of the means: the ends of the bracket are known no better, and a full pixel lies on the upper one [DN].

    Returns
    -------
    SaturationLevel
        The peak lies between the neighbours of the largest value; the standard error is that of a uniform law over the
        bracket. Where the variance still rises at the last level, that level is a lower bound.

    """
    errors = np.broadcast_to(np.asarray(std_error_dn, np.float64), np.shape(signal_dn))
    signal, variance, clipped, doubt = _sorted(signal_dn, variance_dn2, clipped_fraction, _NORMAL_975 * errors)
    peak = int(np.argmax(variance))
    last = peak == signal.size - 1
    below = None if last or peak == 0 else float(signal[peak - 1] - doubt[peak - 1])
    above = None if last else float(signal[peak + 1] + doubt[peak + 1])
    adc_limited = not last and bool(clipped[peak + 1 :].max() > ADC_LIMITED)
    flags = (*((_ADC_FLAG,) if adc_limited else ()), *((LOWER_BOUND,) if last else ()))
    return _bracketed(float(signal[peak]), below, above, flags=flags)


def plateau(
    signal_dn: ArrayLike, clipped_fraction: ArrayLike, std_error_dn: ArrayLike, *, tolerance: float = 0.01
) -> SaturationLevel | None:
    """Return the level that more light no longer raises (METHOD 7b).

    Parameters
    ----------
    signal_dn
        Mean above the black level, by ascending exposure, shape (N,) [DN].
    clipped_fraction
        Share of values on the highest code [1].
    std_error_dn
        Of the means [DN].
    tolerance
        Largest relative rise of the last level over the one before it that still counts as a plateau.

    Returns
    -------
    SaturationLevel or None
        ``adc-limited`` where more than half of the values are on the highest code; None where the signal still rises.

    """
    signal = np.asarray(signal_dn, np.float64)
    if signal.size < 2 or signal[-1] <= 0.0 or signal[-1] - signal[-2] > tolerance * signal[-1]:
        return None
    limited = float(np.asarray(clipped_fraction, np.float64)[-1]) > ADC_LIMITED
    error = float(np.asarray(std_error_dn, np.float64)[-1])
    return SaturationLevel(
        signal=Measured.normal(float(signal[-1]), error, DN),
        flags=(_ADC_FLAG,) if limited else (),
    )


def last_consistent_level(signal_dn: ArrayLike, residual: ArrayLike) -> SaturationLevel | None:
    """Return the last level that the photon transfer curve still describes, |r| < 4 (METHOD 7c).

    Parameters
    ----------
    signal_dn
        Mean above the black level of each point, shape (N,) [DN].
    residual
        Signed deviance of each point [1].

    Returns
    -------
    SaturationLevel or None
        ``lower-bound`` where every level is described; None where none is.

    """
    signal, residuals, _ = _sorted(signal_dn, residual, residual)
    consistent = np.flatnonzero(np.abs(residuals) < CONSISTENT)
    if consistent.size == 0:
        return None
    at = int(consistent[-1])
    last = at == signal.size - 1
    above = None if last else float(signal[at + 1])
    return _bracketed(float(signal[at]), None, above, flags=(LOWER_BOUND,) if last else ())


def _bracketed(value: float, low: float | None, high: float | None, *, flags: tuple[str, ...]) -> SaturationLevel:
    """Return a level whose interval is its bracket; an open bracket starts at the level itself."""
    bottom = value if low is None else low
    if high is None:
        measured = Measured.exact(value, DN)
    else:
        measured = Measured.interval(value, (high - bottom) / math.sqrt(12.0), (bottom, high), DN)
        flags = (*flags, GRID_LIMITED)
    return SaturationLevel(signal=measured, flags=flags)


def _sorted(*columns: ArrayLike) -> tuple[np.ndarray, ...]:
    arrays = [np.asarray(column, np.float64) for column in columns]
    order = np.argsort(arrays[0], kind="stable")
    return tuple(array[order] for array in arrays)
