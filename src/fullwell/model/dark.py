"""A sensor in the dark: its signal and its noise as exposure and temperature grow (METHOD 4)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def dark_signal(exposure_s: ArrayLike, *, dark_current: float, offset: float = 0.0) -> NDArray[np.float64]:
    """Return the dark signal, offset plus current times exposure.

    Parameters
    ----------
    exposure_s
        Exposure [s].
    dark_current
        Rate [e-/s or DN/s].
    offset
        Level at zero exposure [e- or DN].

    """
    return offset + dark_current * np.asarray(exposure_s, dtype=np.float64)


def dark_variance(
    exposure_s: ArrayLike,
    *,
    read_noise: float,
    dark_current: float = 0.0,
    dark_current_spread: float = 0.0,
    offset_spread: float = 0.0,
) -> NDArray[np.float64]:
    """Return the variance of a dark frame, temporal and fixed pattern together (METHOD 4.6).

    Dark-current shot noise is Poisson, so its *variance* is i t; only the pixel-to-pixel spread of the current grows
    as t^2.

    Parameters
    ----------
    exposure_s
        Exposure [s].
    read_noise
        Temporal noise at zero exposure [e-].
    dark_current
        Mean rate [e-/s].
    dark_current_spread
        Standard deviation of the rate over the pixels, DCNU [e-/s].
    offset_spread
        Standard deviation of the level over the pixels at zero exposure, DSNU [e-].

    Returns
    -------
    ndarray
        Shape of ``exposure_s`` [e-^2].

    Examples
    --------
    >>> round(float(dark_variance(10.0, read_noise=2.36, dark_current=2.22)) ** 0.5, 1)
    5.3

    """
    time = np.asarray(exposure_s, dtype=np.float64)
    return read_noise**2 + dark_current * time + (dark_current_spread * time) ** 2 + offset_spread**2


def dark_current_at(
    temperature_c: ArrayLike, *, dark_current: float, reference_c: float, doubling_c: float
) -> NDArray[np.float64]:
    """Return the dark current at a temperature, I0 * 2^((T - T0) / Td) (METHOD 4.5).

    Parameters
    ----------
    temperature_c
        Temperature T [degC].
    dark_current
        Rate at the reference temperature I0 [e-/s or DN/s].
    reference_c
        Reference temperature T0 [degC].
    doubling_c
        Rise in temperature that doubles the current Td [degC].

    """
    return dark_current * np.exp2((np.asarray(temperature_c, dtype=np.float64) - reference_c) / doubling_c)
