"""The figures of the ``emva1288`` Python package 1.0.2, by its own rules (EMVA1288 12): 3.1's saturation and threshold.

Equal to the package's within what its iterative fits leave, about 1e-9. It knows no uncertainties; where it prints NaN
the signed variance stands here, and the figure itself is None.
"""

import math
from dataclasses import dataclass

import numpy as np

from fullwell.figures.emva1288.line import fit_line, slope_through_origin
from fullwell.figures.emva1288.linearity import measure_linearity
from fullwell.figures.emva1288.nonuniformity import Split
from fullwell.figures.emva1288.sensitivity import LEAST_DARK_VARIANCE, QUANTIZATION
from fullwell.figures.emva1288.sweep import Floats, Sweep

_MANY_TIMES = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class PackageFigures:
    """Sensitivity, linearity and dark current; None where the package gives none.

    Parameters
    ----------
    saturation, fit_last, linearity_first, linearity_last
        Steps, counted from 0.
    system_gain, responsivity
        K [DN/e-] and R [DN/p].
    dark_variance
        Not less than 0.24 [DN^2].
    saturation_photons
        Of the step of saturation [p].
    linearity_min, linearity_max, linearity_offset, linearity_slope
        [%, %, DN, DN/p].
    dark_mean_slope, dark_variance_slope
        Against time [DN/s, DN^2/s].

    """

    saturation: int
    fit_last: int
    linearity_first: int
    linearity_last: int
    system_gain: float
    responsivity: float
    dark_variance: float
    saturation_photons: float
    linearity_min: float | None
    linearity_max: float | None
    linearity_offset: float | None
    linearity_slope: float | None
    dark_mean_slope: float | None
    dark_variance_slope: float | None

    @property
    def quantum_efficiency(self) -> float:
        """Return the quantum efficiency, a fraction."""
        return self.responsivity / self.system_gain

    @property
    def threshold_e(self) -> float:
        """Return the sensitivity threshold, (88) of Release 3.1 [e-]."""
        return math.sqrt(self.dark_variance) / self.system_gain + 0.5

    @property
    def dark_noise_e(self) -> float:
        """Return the dark noise without quantization [e-]."""
        return math.sqrt(self.dark_variance - QUANTIZATION) / self.system_gain


def saturation_step(variance: Floats) -> int:
    """Return the step of saturation: from the last step back, the last that did not fall below what came before.

    Examples
    --------
    >>> [saturation_step(np.array(v)) for v in ([1, 2, 3, 4, 5, 4, 1], [1, 2, 3, 5, 4, 6, 1])]
    [4, 5]
    >>> saturation_step(np.array([1, 2, 3, 9, 4, 3, 3.5, 0]))
    3

    """
    highest, found = 0.0, 0
    for step in range(variance.size - 1, -1, -1):
        if variance[step] < highest and variance[abs(step - 1)] < highest:
            break
        highest, found = float(variance[step]), step
    return found


def evaluate(sweep: Sweep) -> PackageFigures | None:
    """Evaluate a sweep as the package does; None where it has no photons.

    Parameters
    ----------
    sweep
        Every step with a dark pair of its own exposure, by ascending exposure and photons.

    """
    if sweep.photons is None or sweep.steps < 2:
        return None
    signal, light_variance = sweep.signal, sweep.light_variance
    saturation = saturation_step(sweep.variance)
    top = float(signal[saturation])
    below = np.flatnonzero(signal <= 0.7 * top)
    above = np.flatnonzero(signal >= 0.05 * top)
    straight = np.flatnonzero(signal <= 0.95 * top)
    if not (below.size and above.size and straight.size):
        return None
    fit_last, first, last = int(below[-1]), int(above[0]), int(straight[-1])
    chosen = slice(0, fit_last + 1)
    line = measure_linearity(
        sweep.photons[first : last + 1], signal[first : last + 1], sweep.signal_error[first : last + 1]
    )
    times = np.unique(sweep.exposure_s).size
    by_time = times >= _MANY_TIMES
    means = fit_line(sweep.exposure_s, sweep.dark_mean) if by_time else None
    variances = fit_line(sweep.exposure_s, sweep.dark_variance) if by_time else None
    dark_variance = float(sweep.dark_variance[0]) if variances is None else variances.offset
    return PackageFigures(
        saturation=saturation,
        fit_last=fit_last,
        linearity_first=first,
        linearity_last=last,
        system_gain=slope_through_origin(signal[chosen], light_variance[chosen]),
        responsivity=slope_through_origin(sweep.photons[chosen], signal[chosen]),
        dark_variance=max(dark_variance, LEAST_DARK_VARIANCE),
        saturation_photons=float(sweep.photons[saturation]),
        linearity_min=None if line is None else float(line.deviation.min()),
        linearity_max=None if line is None else float(line.deviation.max()),
        linearity_offset=None if line is None else line.offset,
        linearity_slope=None if line is None else line.slope,
        dark_mean_slope=None if means is None else means.slope,
        dark_variance_slope=None if variances is None else variances.slope,
    )


def split_unfiltered(
    *, rows: int, columns: int, measured: float, column_means: float, row_means: float, left: float
) -> Split:
    """Return the package's split: total with divisor n - 1, means of columns and rows with N and M.

    Parameters
    ----------
    rows, columns
        M and N.
    measured
        Variance over pixels of the average, divisor n - 1 [DN^2].
    column_means, row_means
        Variance over the means of columns, of rows, divisors N and M [DN^2].
    left
        Temporal variance left in the average [DN^2].

    Examples
    --------
    >>> split = split_unfiltered(
    ...     rows=4, columns=3, measured=31 / 6 * 12 / 11, column_means=0.666666667, row_means=4.0, left=0.05
    ... )
    >>> round(split.total, 6), round(split.column, 6)
    (5.586364, 0.084848)

    """
    total = measured - left
    cav, rav = column_means - left / rows, row_means - left / columns
    n = rows * columns
    freedom = n - rows - columns
    return Split(
        total=total,
        row=((n - columns) * rav - rows * (total - cav)) / freedom,
        column=((n - rows) * cav - columns * (total - rav)) / freedom,
        pixel=n * (total - cav - rav) / freedom,
        column_means=cav,
        row_means=rav,
        total_error=0.0,
        row_error=0.0,
        column_error=0.0,
        pixel_error=0.0,
    )
