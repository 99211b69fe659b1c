"""Responsivity, system gain, thresholds, dynamic range (EMVA1288 3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from fullwell.figures.emva1288.line import Line, fit_line, offset_error_from, slope_error_from, slope_through_origin
from fullwell.figures.emva1288.sweep import Floats, Sweep
from fullwell.units import Measured

FIT_SHARE: Final = 0.7
"""Share of the saturation up to which responsivity and system gain are fitted."""

LEAST_DARK_VARIANCE: Final = 0.24
"""Smallest dark variance that the quantization leaves measurable [DN^2]."""

QUANTIZATION: Final = 1.0 / 12.0
"""Variance of rounding to whole codes [DN^2]."""

_FEWEST: Final = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SystemGain:
    """The photon-transfer line with a free offset.

    Parameters
    ----------
    line
        Least squares, with the standard's 1 sigma of the regression.
    slope_error, offset_error
        Standard errors from the number of pixels behind each step, scaled up where the line misfits [DN/e-, DN^2].
    misfit
        Whether the points scatter about the line beyond the 99 % point of chance.

    """

    line: Line
    slope_error: float
    offset_error: float
    misfit: bool

    @property
    def measured(self) -> Measured:
        """Return the system gain."""
        return Measured.normal(self.line.slope, self.slope_error, "DN/e-")


def fit_range(sweep: Sweep, *, saturation_signal: float) -> NDArray[np.bool_]:
    """Return the steps up to 70 % of saturation."""
    return sweep.signal <= FIT_SHARE * saturation_signal


def fit_system_gain(sweep: Sweep, chosen: NDArray[np.bool_]) -> SystemGain | None:
    """Return the photon-transfer line over some steps, None where fewer than three differ.

    The steps' errors grow with the signal, so the error of the slope is theirs, not that of equal residuals.
    """
    x, y, errors = sweep.signal[chosen], sweep.light_variance[chosen], sweep.light_variance_error[chosen]
    if x.size < _FEWEST or np.ptp(x) == 0.0:
        return None
    line = fit_line(x, y)
    weights = 1.0 / errors**2
    share = np.sqrt(weights)
    weighted = np.linalg.lstsq(np.stack((share, share * x), axis=1), share * y, rcond=None)[0]
    deviance = float(np.sum(weights * (y - weighted[0] - weighted[1] * x) ** 2))
    misfit = deviance > float(chdtri(x.size - 2, 0.01))
    scale = math.sqrt(deviance / (x.size - 2)) if misfit else 1.0
    return SystemGain(
        line=line,
        slope_error=scale * slope_error_from(x, errors),
        offset_error=scale * offset_error_from(x, errors),
        misfit=misfit,
    )


def fit_responsivity(exposure: Floats, sweep: Sweep, chosen: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Return the slope of the signal against the exposure through the origin, (49), and its standard error.

    The error is the larger of that from the scatter about the line and that from the noise of the pixels.
    """
    x, y = exposure[chosen], sweep.signal[chosen]
    power = float(np.sum(x * x))
    if x.size < 2 or power == 0.0:
        return None
    slope = slope_through_origin(x, y)
    residual = y - slope * x
    by_scatter = math.sqrt(float(np.sum((x * residual) ** 2)) * x.size / (x.size - 1)) / power
    by_noise = math.sqrt(float(np.sum((x * sweep.signal_error[chosen]) ** 2))) / power
    return slope, max(by_scatter, by_noise)


def dark_variance(variance: float, n: int) -> tuple[Measured, bool]:
    """Return the dark variance, not less than 0.24 DN^2, and whether it was less: then it is an upper limit."""
    if variance >= LEAST_DARK_VARIANCE:
        return Measured.normal(variance, variance * math.sqrt(2.0 / n), "DN^2"), False
    return Measured.interval(LEAST_DARK_VARIANCE, None, (0.0, LEAST_DARK_VARIANCE), "DN^2"), True


def threshold_electrons(values: Sequence[float] | Floats) -> float:
    """Return the sensitivity threshold of a dark variance [DN^2] and a system gain [DN/e-], (27) [e-].

    Examples
    --------
    >>> round(threshold_electrons((1.0049333333, 0.4)), 6)
    3.05555

    """
    variance, system_gain = values[0], values[1]
    return math.sqrt(variance / system_gain**2 + 0.25) + 0.5


def threshold_at(snr: float, variance: float, system_gain: float) -> float:
    """Return the signal at which the signal-to-noise ratio is ``snr``, (25) times the quantum efficiency [e-].

    Examples
    --------
    >>> round(threshold_at(10.0, 0.96**2 + 1 / 12, 0.4) / 0.6, 6) == round(
    ...     threshold_at(10.0, 1.0049333333, 0.4) / 0.6, 6
    ... )
    True

    """
    dark = variance / system_gain**2
    return 0.5 * snr**2 * (1.0 + math.sqrt(1.0 + 4.0 * dark / snr**2))


def snr_model(electrons: Floats, *, dark_e2: float, dsnu_e2: float = 0.0, prnu: float = 0.0) -> Floats:
    """Return the signal-to-noise ratio, (21), or with fixed pattern, (69).

    Parameters
    ----------
    electrons
        Signal [e-].
    dark_e2
        Temporal dark variance with quantization [e-^2].
    dsnu_e2, prnu
        Fixed pattern in the dark [e-^2] and of the response, as a fraction.

    """
    return electrons / np.sqrt(dark_e2 + dsnu_e2 + electrons + (prnu * electrons) ** 2)
