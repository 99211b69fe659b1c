"""Dynamic range of the sensor: saturation over the signal at which the signal-to-noise ratio crosses a threshold."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.ratios import Ratio, ratio
from fullwell.model.photon_transfer import signal_at_snr, signal_at_snr_gradient
from fullwell.units import DN, Measured, combined_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class DynamicRange:
    """Dynamic range for one threshold.

    Parameters
    ----------
    snr
        The threshold [1].
    threshold_signal
        Signal at the threshold [DN].
    range
        Saturation over it.

    """

    snr: float
    threshold_signal: Measured
    range: Ratio


def dynamic_range(
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    saturation: Measured,
    *,
    snr: float = 1.0,
    dof: float | None = None,
) -> DynamicRange:
    """Return the dynamic range from the noise model by the delta method (METHOD 7).

    Parameters
    ----------
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] of a single frame and their covariance, shapes (3,) and (3, 3).
    saturation
        Saturation signal above the black level, with its error where it has one [DN].
    snr
        Threshold.
    dof
        Degrees of freedom of the covariance; None for many.

    Returns
    -------
    DynamicRange

    Raises
    ------
    ValueError
        Where the model never crosses the threshold: then there is no dynamic range to be told.

    """
    dark, shot, fixed = (float(value) for value in coefficients)
    signal = signal_at_snr(snr, dark=dark, shot=shot, fixed_pattern=fixed)
    if not (math.isfinite(signal) and signal > 0.0):
        raise ValueError(f"the noise model never reaches a signal-to-noise ratio of {snr:g}")
    gradient = signal_at_snr_gradient(snr, dark=dark, shot=shot, fixed_pattern=fixed)
    signal_error = float(np.sqrt(gradient @ covariance @ gradient))
    saturation_error = (saturation.std_error or 0.0) / saturation.value
    parts = ((signal_error / signal, dof), (saturation_error, saturation.dof))
    return DynamicRange(
        snr=snr,
        threshold_signal=Measured.student(signal, signal_error, dof, DN),
        range=ratio(
            saturation.value / signal, math.hypot(signal_error / signal, saturation_error), combined_dof(*parts)
        ),
    )
