"""The photon transfer curve: how the variance of a pixel grows with its signal.

Every function works in any consistent unit of signal: DN with coefficients in DN^2, DN and 1, or the normalized
signal V = S / D with the coefficients of METHOD 0.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def noise_variance(signal: ArrayLike, *, dark: float, shot: float, fixed_pattern: float = 0.0) -> NDArray[np.float64]:
    """Return the variance A + B S + C S^2 (METHOD 0).

    Parameters
    ----------
    signal
        Signal above the black level, any shape [DN].
    dark
        A, the variance without signal [DN^2].
    shot
        B, the system gain [DN/e-].
    fixed_pattern
        C, the squared PRNU of a single frame, or the signed curvature of a temporal variance [1].

    Returns
    -------
    ndarray
        Shape of ``signal`` [DN^2].

    Examples
    --------
    >>> float(noise_variance(100.0, dark=4.0, shot=0.5))
    54.0

    """
    level = np.asarray(signal, dtype=np.float64)
    return dark + shot * level + fixed_pattern * level**2


def signal_to_noise(signal: ArrayLike, *, dark: float, shot: float, fixed_pattern: float = 0.0) -> NDArray[np.float64]:
    """Return S / sqrt(A + B S + C S^2), arguments as in `noise_variance` (METHOD 7)."""
    level = np.asarray(signal, dtype=np.float64)
    return level / np.sqrt(noise_variance(level, dark=dark, shot=shot, fixed_pattern=fixed_pattern))


def signal_at_snr(snr: float, *, dark: float, shot: float, fixed_pattern: float = 0.0) -> float:
    """Return the signal at which the signal-to-noise ratio crosses a threshold (METHOD 7).

    Parameters
    ----------
    snr
        The threshold s.
    dark, shot, fixed_pattern
        As in `noise_variance`.

    Returns
    -------
    float
        The positive root of (1 - s^2 C) S^2 - s^2 B S - s^2 A = 0 [DN]; infinite where fixed pattern noise keeps the
        ratio below the threshold at any signal, NaN where A is so negative that there is no crossing.

    Examples
    --------
    >>> signal_at_snr(1.0, dark=0.0, shot=0.5)
    0.5

    """
    squared = snr * snr
    leading = 1.0 - squared * fixed_pattern
    if leading <= 0.0:
        return float("inf")
    discriminant = (squared * shot) ** 2 + 4.0 * squared * dark * leading
    if discriminant < 0.0:
        return float("nan")
    return float((squared * shot + np.sqrt(discriminant)) / (2.0 * leading))


def signal_at_snr_gradient(snr: float, *, dark: float, shot: float, fixed_pattern: float = 0.0) -> NDArray[np.float64]:
    """Return the derivatives of `signal_at_snr` with respect to A, B and C, shape (3,) (implicit differentiation)."""
    level = signal_at_snr(snr, dark=dark, shot=shot, fixed_pattern=fixed_pattern)
    squared = snr * snr
    slope = 2.0 * (1.0 - squared * fixed_pattern) * level - squared * shot
    return squared * np.array([1.0, level, level**2]) / slope
