"""Is a figure the same everywhere: at every ISO, in every region (METHOD 5.6)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc

from fullwell.fit.pooling import weighted_mean
from fullwell.units import DN2, Measured, combined_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class Constancy:
    """Several measurements held against one common value.

    Parameters
    ----------
    chi_square, dof
        Their disagreement, and its degrees of freedom: measurements less one.
    p_value
        Chance of a larger disagreement if the figure is the same for all.
    mean
        The common value.

    """

    chi_square: float
    dof: int
    p_value: float
    mean: Measured


def constancy(measurements: Sequence[Measured], *, errors: Sequence[float] | None = None) -> Constancy:
    """Test whether measurements agree on one value (Welch where their errors are uncertain).

    Parameters
    ----------
    measurements
        At least one, of one unit.
    errors
        Standard errors that leave out what all measurements share, such as `Nonuniformity.repeat_error`; None: the
        measurements' own. What the own error has beyond them enters the error of the mean once, undivided.

    Returns
    -------
    Constancy
        Of the measurements that have an error above zero; with fewer than two of these, p-value 1.

    Raises
    ------
    ValueError
        Where there is no measurement, or ``errors`` are of another number.

    """
    if not measurements or (errors is not None and len(errors) != len(measurements)):
        raise ValueError("constancy needs measurements, and as many errors as measurements where errors are given")
    own = [measured.std_error or 0.0 for measured in measurements]
    alone = own if errors is None else list(errors)
    known = [at for at, error in enumerate(alone) if error > 0.0]
    if not known:
        mean = sum(measured.value for measured in measurements) / len(measurements)
        return Constancy(chi_square=0.0, dof=0, p_value=1.0, mean=Measured.exact(mean, measurements[0].unit))
    weighted = weighted_mean([replace(measurements[at], std_error=alone[at]) for at in known])
    share = np.array([alone[at] ** -2.0 for at in known])
    values = np.array([measurements[at].value for at in known])
    chi_square = float(share @ (values - weighted.measured.value) ** 2)
    common = float(share @ [max(own[at] ** 2 - alone[at] ** 2, 0.0) for at in known] / share.sum())
    return Constancy(
        chi_square=chi_square,
        dof=len(known) - 1,
        p_value=weighted.p_value,
        mean=_with_common_error(weighted.measured, math.sqrt(common)),
    )


def equal_variances(variances: ArrayLike, dof: ArrayLike) -> Constancy:
    """Test whether regions have the same variance (Bartlett).

    Parameters
    ----------
    variances
        Independent variance estimates, any shape [DN^2].
    dof
        Their degrees of freedom, of the same shape or one for all, fewer where pixels share noise (METHOD 1.8, 3.6);
        estimates without any are left out.

    """
    variance, nu = (
        np.ravel(each) for each in np.broadcast_arrays(*(np.asarray(one, np.float64) for one in (variances, dof)))
    )
    known = np.isfinite(variance) & (nu > 0.0)
    if not known.any():
        raise ValueError("a test of equal variances needs an estimate with degrees of freedom")
    variance, nu = variance[known], nu[known]
    total = float(nu.sum())
    mean = float(nu @ variance) / total
    pooled = Measured.normal(mean, mean * math.sqrt(2.0 / total), DN2)
    groups = variance.size
    if groups < 2 or mean <= 0.0:
        return Constancy(chi_square=0.0, dof=groups - 1, p_value=1.0, mean=pooled)
    with np.errstate(divide="ignore"):
        ratio = float(nu @ np.log(mean / np.maximum(variance, 0.0)))
    correction = 1.0 + (float(np.sum(1.0 / nu)) - 1.0 / total) / (3.0 * (groups - 1))
    chi_square = max(ratio, 0.0) / correction
    return Constancy(chi_square=chi_square, dof=groups - 1, p_value=float(chdtrc(groups - 1, chi_square)), mean=pooled)


def _with_common_error(mean: Measured, common: float) -> Measured:
    """Widen the error of a mean by one that all its members share."""
    error = mean.std_error or 0.0
    dof = combined_dof((error, mean.dof), (common, None))
    return Measured.student(mean.value, math.hypot(error, common), dof, mean.unit)
