"""Noise coefficients: one camera in three dialects (METHOD 0 and 8).

k's are standard deviations of the normalized signal V = S / D; A, B, C are variances in DN; EMVA 1288 speaks of
electrons. D is the digital maximum: 2^bits - 1, or that less the black level; the k's depend on which, so say it.
"""

import math
from dataclasses import dataclass

from fullwell.model.conversions import k_shot_variance, unlit_electrons2


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseCoefficients:
    """The noise model sigma^2 = k_dark^2 + k_shot^2 V + k_fpn^2 V^2 of the normalized signal [1]."""

    k_dark: float
    k_shot: float
    k_fpn: float

    def variances_dn(self, digital_maximum: float) -> tuple[float, float, float]:
        """Return A [DN^2], B [DN/e-] and C [1] for a digital maximum D [DN].

        Examples
        --------
        >>> round(NoiseCoefficients(k_dark=0.0, k_shot=5.554e-3, k_fpn=0.0).variances_dn(16383.0)[1], 4)
        0.5054

        """
        return (
            (digital_maximum * self.k_dark) ** 2,
            digital_maximum * self.k_shot**2,
            self.k_fpn**2,
        )


def noise_coefficients(
    *,
    system_gain: float,
    digital_maximum: float,
    dark_noise: float,
    prnu: float,
    offset_spread: float = 0.0,
    dark_electrons: float = 0.0,
    step: float = 1.0,
) -> NoiseCoefficients:
    """Return the k's of a camera described in electrons (METHOD 8).

    Parameters
    ----------
    system_gain
        K [DN/e-].
    digital_maximum
        D [DN].
    dark_noise
        Temporal noise in the dark, without quantization [e-].
    prnu
        Photo-response non-uniformity as a fraction [1].
    offset_spread
        DSNU [e-].
    dark_electrons
        Dark current times exposure [e-]; its variance equals it.
    step
        Distance of two codes q [DN].

    """
    electrons2 = unlit_electrons2(
        dark_noise**2,
        system_gain=system_gain,
        dsnu_electrons2=offset_spread**2,
        dark_electrons=dark_electrons,
        step=step,
    )
    return NoiseCoefficients(
        k_dark=system_gain / digital_maximum * math.sqrt(electrons2),
        k_shot=math.sqrt(k_shot_variance(system_gain, digital_maximum=digital_maximum)),
        k_fpn=prnu,
    )
