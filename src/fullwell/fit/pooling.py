"""Several measurements of one quantity: their weighted mean, and whether they agree.

The errors are estimates themselves. Where few degrees of freedom stand behind them, Welch's test replaces chi-square
and Meier's factor widens the error of the mean.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import fdtrc

from fullwell.units import Measured, combined_dof

SIGNIFICANCE: Final = 0.01
"""Chance that measurements which are the same are said to differ."""
_FEW: Final = 8.0
"""Degrees of freedom below which an error is too uncertain to weight by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WeightedMean:
    """An inverse-variance weighted mean and its homogeneity test.

    Parameters
    ----------
    measured
        The mean.
    p_value
        Chance of a larger disagreement if all measure the same quantity (Welch).

    """

    measured: Measured
    p_value: float


def weighted_mean(measurements: Sequence[Measured]) -> WeightedMean:
    """Return the inverse-variance weighted mean of measurements with standard errors above zero (METHOD 2.4).

    Raises
    ------
    ValueError
        Where there is none, or one has no standard error.

    """
    if not measurements or any(not measured.std_error for measured in measurements):
        raise ValueError("a weighted mean needs measurements, each with a standard error above zero")
    unit = measurements[0].unit
    value = np.array([measured.value for measured in measurements])
    error = np.array([measured.std_error for measured in measurements], dtype=np.float64)
    dof = np.array([math.inf if measured.dof is None else measured.dof for measured in measurements])
    weight = error**-2
    share = weight / weight.sum()
    mean = float(share @ value)
    q = float(weight @ (value - mean) ** 2)
    meier = 1.0 + 4.0 * float(np.sum(share * (1.0 - share) / dof))
    return WeightedMean(
        measured=Measured.student(
            mean,
            math.sqrt(meier / float(weight.sum())),
            combined_dof(*zip((share * error).tolist(), dof.tolist(), strict=True)),
            unit,
        ),
        p_value=_welch_p(q, share, dof),
    )


def pool_channels(measurements: Sequence[Measured]) -> tuple[Measured, float]:
    """Return one figure for all channels, and the p-value of the hypothesis that they agree.

    Parameters
    ----------
    measurements
        One per channel, independent of each other. Channels of the same frames share whatever moves whole frames:
        where that matters (black level, dark current), fit the mean of the channels instead.

    Returns
    -------
    tuple of Measured and float
        Weighted by inverse variance; equally, where an error has fewer than eight degrees of freedom, since weights
        that uncertain do harm. Measurements without an error are averaged, p-value 1, no error.

    """
    known = [measured for measured in measurements if measured.std_error]
    if not known:
        mean = float(np.mean([measured.value for measured in measurements]))
        return Measured.exact(mean, measurements[0].unit), 1.0
    if len(known) == 1:
        return known[0], 1.0
    weighted = weighted_mean(known)
    if all(measured.dof is None or measured.dof >= _FEW for measured in known):
        return weighted.measured, weighted.p_value
    return equal_mean(known), weighted.p_value


def equal_mean(measurements: Sequence[Measured]) -> Measured:
    """Return the plain mean of independent measurements with standard errors; Welch-Satterthwaite dof."""
    parts = [(measured.std_error or 0.0, measured.dof) for measured in measurements]
    mean = float(np.mean([measured.value for measured in measurements]))
    error = math.hypot(*(error for error, _ in parts)) / len(measurements)
    return Measured.student(mean, error, combined_dof(*parts), measurements[0].unit)


def _welch_p(q: float, share: np.ndarray, dof: np.ndarray) -> float:
    """Return the p-value of Welch's test of equal means; chi-square where all errors are known."""
    groups = share.size
    if groups < 2:
        return 1.0
    doubt = float(np.sum((1.0 - share) ** 2 / dof))
    numerator = q / (groups - 1) / (1.0 + 2.0 * (groups - 2) * doubt / (groups**2 - 1))
    denominator = (groups**2 - 1) / (3.0 * doubt) if doubt > 0.0 else math.inf
    return float(fdtrc(groups - 1, min(denominator, 1e9), numerator))


def mean_sharing_errors(measurements: Sequence[Measured]) -> Measured:
    """Return the mean of measurements that err together, such as levels that one tag declares: its error is theirs.

    Examples
    --------
    >>> mean_sharing_errors([Measured.normal(1.0, 0.3, "DN"), Measured.normal(3.0, 0.3, "DN")]).std_error
    0.3

    """
    value = sum(one.value for one in measurements) / len(measurements)
    error = sum(one.std_error or 0.0 for one in measurements) / len(measurements)
    return Measured.normal(value, error, measurements[0].unit)
