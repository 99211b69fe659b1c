"""Noise models in their dialects: one formula a function, floats in and out.

k's are standard deviations of V = S / D; DN and electrons differ by the system gain K; EMVA 1288 counts electrons and
takes rounding off; the tag NoiseProfile of a DNG has the variance S x + O of x = (code - black) / (white - black).
Fixed pattern noise is the same number in all of them: k_fpn = sqrt(C), at least PRNU. `noise.noise_coefficients` goes
from electrons to all three k's at once.
"""

import math
from typing import Final

EMVA_VARIANCE_FLOOR: Final = 0.24
"""Temporal dark variance in codes squared below which rounding hides the noise (EMVA1288 3)."""


def k_dark_variance(dark_dn2: float, *, digital_maximum: float) -> float:
    """Return k_dark^2 = A / D^2 [1] of a variance in the dark A [DN^2], D [DN] (METHOD 0)."""
    return dark_dn2 / digital_maximum**2


def dark_variance(k_dark_variance: float, *, digital_maximum: float) -> float:
    """Return A = D^2 k_dark^2 [DN^2] (METHOD 0)."""
    return digital_maximum**2 * k_dark_variance


def k_shot_variance(system_gain: float, *, digital_maximum: float) -> float:
    """Return k_shot^2 = K / D [1] of a system gain K [DN/e-] (METHOD 8).

    Examples
    --------
    >>> round(k_shot_variance(0.425, digital_maximum=4095.0) ** 0.5, 6)
    0.010187

    """
    return system_gain / digital_maximum


def system_gain_of_k(k_shot_variance: float, *, digital_maximum: float) -> float:
    """Return K = D k_shot^2 [DN/e-] (METHOD 8).

    Examples
    --------
    >>> round(system_gain_of_k(0.005554**2, digital_maximum=16383.0), 4)
    0.5054

    """
    return digital_maximum * k_shot_variance


def rounding_electrons2(*, system_gain: float, step: float = 1.0) -> float:
    """Return q^2 / (12 K^2), the variance of rounding [e-^2], for a code step q [DN] (METHOD 8)."""
    return (step / system_gain) ** 2 / 12.0


def unlit_electrons2(
    read_electrons2: float,
    *,
    system_gain: float,
    dsnu_electrons2: float = 0.0,
    dark_electrons: float = 0.0,
    step: float = 1.0,
) -> float:
    """Return the variance of one frame in the dark, read^2 + DSNU^2 + i t + q^2/12K^2 [e-^2] (METHOD 4.6, 8).

    Parameters
    ----------
    read_electrons2, dsnu_electrons2
        Variance of the temporal noise without rounding, and of the offsets [e-^2].
    system_gain
        K [DN/e-].
    dark_electrons
        Dark current times exposure, i t [e-]: a Poisson charge, so its variance is i t, not (i t)^2.
    step
        Distance of two codes q [DN].

    Examples
    --------
    >>> round(unlit_electrons2(2.36**2, dsnu_electrons2=0.703**2, system_gain=0.425, step=0.0) ** 0.5, 4)
    2.4625

    """
    rounding = rounding_electrons2(system_gain=system_gain, step=step)
    return read_electrons2 + dsnu_electrons2 + dark_electrons + rounding


def read_noise_electrons2(
    total_electrons2: float,
    *,
    system_gain: float,
    dsnu_electrons2: float = 0.0,
    dark_electrons: float = 0.0,
    step: float = 1.0,
) -> float:
    """Return the variance of read noise left in that of one frame in the dark [e-^2] (METHOD 8, solved for it).

    Parameters
    ----------
    total_electrons2
        Variance of a frame in the dark, A / K^2 [e-^2].
    system_gain
        K [DN/e-].
    dsnu_electrons2
        Variance of the offsets [e-^2]; what is not given stays in the result, which is then an upper bound.
    dark_electrons
        Dark current times exposure [e-].
    step
        Distance of two codes q [DN].

    Returns
    -------
    float
        Negative where the parts are more than the whole.

    """
    return total_electrons2 - dsnu_electrons2 - dark_electrons - rounding_electrons2(system_gain=system_gain, step=step)


def noise_profile_scale(system_gain: float, *, signal_range: float) -> float:
    """Return S = K / (white - black) [1] of the tag NoiseProfile, signal_range = white - black [DN] (DNG)."""
    return system_gain / signal_range


def noise_profile_offset(variance_dn2: float, *, signal_range: float) -> float:
    """Return O = A / (white - black)^2 [1] of the tag NoiseProfile (DNG)."""
    return variance_dn2 / signal_range**2


def system_gain_of_noise_profile(scale: float, *, signal_range: float) -> float:
    """Return K = S (white - black) [DN/e-] (DNG)."""
    return scale * signal_range


def variance_of_noise_profile(offset: float, *, signal_range: float) -> float:
    """Return A = O (white - black)^2 [DN^2] (DNG)."""
    return offset * signal_range**2


def sensitivity_threshold(temporal_electrons2: float) -> float:
    """Return the electrons at which SNR is 1, sqrt(sigma^2 + 1/4) + 1/2 [e-] (EMVA1288 4.0 Linear).

    Parameters
    ----------
    temporal_electrons2
        Temporal variance in the dark, rounding left in: sigma_d^2 + q^2/12K^2 [e-^2].

    Examples
    --------
    >>> round(sensitivity_threshold(2.4**2 + rounding_electrons2(system_gain=0.4)), 9)
    3.055549517

    """
    return math.sqrt(temporal_electrons2 + 0.25) + 0.5


def reference_sensitivity_threshold(temporal_electrons2: float) -> float:
    """Return sqrt(sigma^2) + 1/2 [e-], as the reference implementation has it (METHOD 7; EMVA1288-PY).

    Examples
    --------
    >>> round(reference_sensitivity_threshold(2.4**2 + rounding_electrons2(system_gain=0.4)), 9)
    3.00615908

    """
    return math.sqrt(temporal_electrons2) + 0.5
