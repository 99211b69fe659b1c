"""Several measurements of one quantity: their weighted mean, and whether they agree.

The errors are estimates themselves. Where few degrees of freedom stand behind them, Welch's test replaces chi-square
and Meier's factor widens the error of the mean.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from fullwell.fit.variance_components import modified_large_sample_interval
from fullwell.units import Measured, combined_dof, welch_dof

SIGNIFICANCE: Final = 0.01
"""Chance that measurements which are the same are said to differ."""
_FEW: Final = 8.0
"""Degrees of freedom below which an error is too uncertain to weight by."""
_SITES: Final = ((0, 1, 2, 3),)
_BESIDE: Final = ((0, 1), (2, 3))
_ABOVE: Final = ((0, 2), (1, 3))


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
            welch_dof(*zip((share * error).tolist(), dof.tolist(), strict=True)),
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
    return Measured.student(mean, error, welch_dof(*parts), measurements[0].unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedErrors:
    """Parts of the standard error of one CFA site's figure that other sites of its cell have in common.

    Each is an error and its degrees of freedom, in the unit of the figure.

    Parameters
    ----------
    frame, rounding
        In common with all sites: what moves whole frames, and the phase of the level within a code.
    row, column
        In common with the site beside it, and with that above or below it.

    """

    frame: tuple[float, float | None] = (0.0, None)
    rounding: tuple[float, float | None] = (0.0, None)
    row: tuple[float, float | None] = (0.0, None)
    column: tuple[float, float | None] = (0.0, None)

    @classmethod
    def of_variances(cls, *, frame: float = 0.0, row: float, column: float, dof: tuple[float, float, float]) -> Self:
        """Return the errors that so much variance of whole frames, rows and columns has for being a sample.

        Parameters
        ----------
        frame, row, column
            Variances; below zero counts as none.
        dof
            Degrees of freedom of each.

        """

        def error(variance: float, known: float) -> tuple[float, float]:
            return max(variance, 0.0) * math.sqrt(2.0 / known), float(known)

        return cls(frame=error(frame, dof[0]), row=error(row, dof[1]), column=error(column, dof[2]))

    def scaled(self, factor: float) -> Self:
        """Return the same errors of a figure that is multiplied by a factor."""
        parts = {part.name: getattr(self, part.name) for part in fields(self)}
        return replace(self, **{name: (error * factor, dof) for name, (error, dof) in parts.items()})


def mean_of_sites(
    measurements: Sequence[Measured], shared: Sequence[SharedErrors], *, weighted: bool = False
) -> Measured:
    """Return the mean of one figure over the four sites of a CFA cell, row-major (METHOD 1.10).

    Parameters
    ----------
    measurements
        One per site, each with a standard error.
    shared
        What of each error other sites have in common: it does not average out.
    weighted
        By inverse variance, where no error of its own has fewer than eight degrees of freedom. A variance of few lines
        has an error that follows its value: weights leave what is shared out, or the mean would be too low.

    """
    own = [_own(measured, common) for measured, common in zip(measurements, shared, strict=True)]
    by_variance = weighted and all(error and (dof is None or dof >= _FEW) for error, dof in own)
    weights = np.array([error**-2 if by_variance else 1.0 for error, _ in own])
    weights /= weights.sum()
    parts: list[tuple[float, float | None]] = [
        (float(weight) * error, dof) for weight, (error, dof) in zip(weights, own, strict=True)
    ]
    for of_all in ([one.frame for one in shared], [one.rounding for one in shared]):
        parts += _together(of_all, weights, _SITES)
    lines = _together([one.row for one in shared], weights, _BESIDE)
    lines += _together([one.column for one in shared], weights, _ABOVE)
    mean = float(weights @ np.array([measured.value for measured in measurements]))
    error = math.hypot(*(error for error, _ in parts))
    return with_lines(Measured.student(mean, error, combined_dof(*parts), measurements[0].unit), lines)


def with_lines(variance: Measured, lines: Iterable[tuple[float, float | None]]) -> Measured:
    """Return a variance with the error that a sample of few rows and columns adds to it (METHOD 1.4, 3.5).

    Variances of lines follow chi-square, whose interval reaches further up than down: the modified large-sample method
    (Graybill and Wang) joins it to the rest.

    Parameters
    ----------
    variance
        With the rest of its error, and an interval.
    lines
        Errors for being a sample and their degrees of freedom, as `SharedErrors` has them.

    """
    known = [(error, dof) for error, dof in lines if error > 0.0 and dof is not None]
    if not known or variance.ci95 is None:
        return variance
    rest = (variance.std_error or 0.0, variance.dof)
    errors, dof = (np.array(column) for column in zip(*known, strict=True))
    part = errors * np.sqrt(dof / 2.0)
    low, high = modified_large_sample_interval(part, dof)
    return replace(
        variance,
        std_error=math.hypot(rest[0], *errors),
        dof=combined_dof(rest, *known),
        ci95=(
            variance.value - math.hypot(variance.value - variance.ci95[0], float(part.sum()) - low),
            variance.value + math.hypot(variance.ci95[1] - variance.value, high - float(part.sum())),
        ),
    )


def _own(measured: Measured, common: SharedErrors) -> tuple[float, float | None]:
    """Return what is left of an error without that which sites share, and its degrees of freedom."""
    shared = (common.frame, common.rounding, common.row, common.column)
    whole = measured.std_error or 0.0
    error = math.sqrt(max(whole**2 - sum(part**2 for part, _ in shared), 0.0))
    doubt = 0.0 if measured.dof is None else whole**4 / measured.dof
    doubt -= sum(part**4 / dof for part, dof in shared if dof is not None)
    if measured.dof is None or doubt <= 0.0:
        return error, None
    return error, max(error**4 / doubt, measured.dof)


def _together(
    errors: Sequence[tuple[float, float | None]], weights: NDArray[np.float64], groups: Iterable[Sequence[int]]
) -> list[tuple[float, float | None]]:
    return [(sum(float(weights[site]) * errors[site][0] for site in group), errors[group[0]][1]) for group in groups]


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
