"""Read noise before and after the amplifier, from its growth with ISO (METHOD 3.7).

The two add in variance, (pre g)^2 + post^2: a line through *noise* against ISO has no meaning.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fullwell.fit.goodness import CheckedFit, fit_checked
from fullwell.model.quantization import quantization_variance
from fullwell.units import DN2, Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class AmplifierNoise:
    """sigma^2 = (pre g)^2 + post^2, fitted.

    Parameters
    ----------
    pre_variance
        Square of the noise before the amplifier, referred to its output at g = 1, signed [DN^2].
    post_variance
        Square of the noise after it, quantization removed, signed [DN^2].
    misfit
        Whether the deviance lies beyond its 99 % point.

    """

    pre_variance: Measured
    post_variance: Measured
    misfit: bool


def fit_amplifier_noise(
    amplification: ArrayLike, variance_dn2: ArrayLike, dof: ArrayLike, *, quantization_step: float = 1.0
) -> AmplifierNoise:
    """Fit temporal dark variances against squared amplification by gamma likelihood (METHOD 3.7).

    Parameters
    ----------
    amplification
        g of each point, ISO over base ISO, shape (n,), at least two different values.
    variance_dn2
        Temporal variance of the dark pixels, quantization included [DN^2].
    dof
        Degrees of freedom of each: 2 variance^2 / std_error^2.
    quantization_step
        Distance of two codes q [DN]; q^2/12 is taken off the noise after the amplifier.

    Raises
    ------
    ValueError
        Where there are fewer than two different amplifications.

    """
    squared = np.asarray(amplification, np.float64) ** 2
    if np.unique(squared).size < 2:
        raise ValueError("noise before and after the amplifier shows only at two or more ISOs")
    checked = fit_checked(
        CheckedFit,
        np.stack([np.ones_like(squared), squared], axis=-1),
        np.asarray(variance_dn2, np.float64),
        np.asarray(dof, np.float64),
        low_signal=None,
        reject_outliers=False,
    )
    after = checked.coefficient(0, DN2)
    rounding = quantization_variance(quantization_step)
    return AmplifierNoise(
        pre_variance=checked.coefficient(1, DN2),
        post_variance=Measured.student(after.value - rounding, after.std_error or 0.0, after.dof, DN2),
        misfit=checked.misfit,
    )
