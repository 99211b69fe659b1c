"""Whether errors are what they claim: pulls, and what many repeats of one measurement of a known truth tell.

Which function: `pull` for one figure, `calibration` for the same figure measured again and again.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.units import Measured

_SMALLEST: Final = 1e-300
NOMINAL: Final = 0.95
"""Coverage that an interval claims [1]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trials:
    """One figure of a known truth in n repeats.

    Parameters
    ----------
    truth
        The true value [unit].
    values
        As reported, shape (n,) [unit].
    std_errors
        Reported standard errors, NaN where there was none, shape (n,) [unit].
    low, high
        Ends of the reported 95 % intervals, NaN where there was none, shape (n,) [unit].
    pulls
        NaN where there was none, shape (n,) [1].
    bounds
        Repeats whose value is only a lower bound. Of a figure that has one, neither values nor pulls tell anything.

    """

    truth: float
    values: NDArray[np.float64]
    std_errors: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    pulls: NDArray[np.float64]
    bounds: int = 0

    @property
    def told_pulls(self) -> NDArray[np.float64]:
        """Return the pulls that there are; none where some of the values are bounds."""
        return self.pulls[np.isfinite(self.pulls) & (self.bounds == 0)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """How a figure behaves over repeats, each with a sensor and noise of its own.

    Parameters
    ----------
    trials
        Repeats that reported the figure.
    bounds
        Those in which it is only a lower bound; it has no bias, scatter and pulls if there are any.
    truth, mean
        The true value, and the mean of the reported ones [unit].
    bias_std_error
        Monte Carlo error of the mean less the truth; None for a single repeat, and of bounds [unit].
    sd
        Standard deviation of the reported values; None for a single repeat, and of bounds [unit].
    std_error
        Root mean square of the reported standard errors; None where there are none [unit].
    intervals, covering
        Repeats with an interval, and those whose interval holds the truth.
    coverage_low, coverage_high
        Interval of Clopper and Pearson for the coverage, 95 %; None without intervals [1].
    coverage_p
        Probability of a coverage so far from 95 %, were it 95 % [1].
    pulls
        Repeats with a pull.
    pull_mean, pull_sd
        Of the pulls; 0 and 1 where errors are honest.
    pull_p
        Probability, by Kolmogorov and Smirnov, of pulls so far from normal ones [1].

    """

    trials: int
    bounds: int
    truth: float
    mean: float
    bias_std_error: float | None
    sd: float | None
    std_error: float | None
    intervals: int
    covering: int
    coverage_low: float | None
    coverage_high: float | None
    coverage_p: float | None
    pulls: int
    pull_mean: float | None
    pull_sd: float | None
    pull_p: float | None

    @property
    def bias(self) -> float | None:
        """Mean less truth; None where some of the values are bounds [unit]."""
        return None if self.bounds else self.mean - self.truth

    @property
    def coverage(self) -> float | None:
        """Share of the intervals that hold the truth [1]."""
        return self.covering / self.intervals if self.intervals else None

    @property
    def scatter_ratio(self) -> float | None:
        """Standard deviation of the values over the reported standard error [1]."""
        return self.sd / self.std_error if self.sd is not None and self.std_error else None


def pull(measured: Measured, truth: float) -> float | None:
    """Return the error in standard errors on the scale of a normal number; None without a standard error.

    Student's t with the measurement's degrees of freedom is mapped to the normal number of the same probability, so
    that figures with few and with many degrees of freedom can be judged alike.

    Examples
    --------
    >>> round(pull(Measured.student(12.706, 1.0, 1, "DN"), 0.0) or 0.0, 2)
    1.96

    """
    if not measured.std_error:
        return None
    t = (measured.value - truth) / measured.std_error
    if measured.dof is None:
        return t
    from scipy.special import ndtri, stdtr  # noqa: PLC0415 - loads when used

    away = -float(ndtri(max(float(stdtr(measured.dof, -abs(t))), _SMALLEST)))
    return away if t > 0.0 else -away


def calibration(trials: Trials) -> Calibration:
    """Return what repeats of one figure tell of its errors.

    Parameters
    ----------
    trials
        At least one.

    Examples
    --------
    >>> ones, values = np.ones(2), np.array([1.0, 3.0])
    >>> found = calibration(
    ...     Trials(truth=2.0, values=values, std_errors=ones, low=values - 2.0, high=values + 2.0, pulls=values - 2.0)
    ... )
    >>> found.bias, round(found.sd or 0.0, 3), found.covering
    (0.0, 1.414, 2)

    """
    values, errors = trials.values, trials.std_errors[np.isfinite(trials.std_errors)]
    known = np.isfinite(trials.low) & np.isfinite(trials.high)
    covering = int(np.sum((trials.low <= trials.truth) & (trials.truth <= trials.high) & known))
    pulls = trials.told_pulls
    sd = float(values.std(ddof=1)) if values.size > 1 and not trials.bounds else None
    low, high, p_value = _coverage(covering, int(known.sum()))
    return Calibration(
        trials=int(values.size),
        bounds=trials.bounds,
        truth=trials.truth,
        mean=float(values.mean()),
        bias_std_error=None if sd is None else sd / math.sqrt(values.size),
        sd=sd,
        std_error=float(np.sqrt(np.mean(errors**2))) if errors.size else None,
        intervals=int(known.sum()),
        covering=covering,
        coverage_low=low,
        coverage_high=high,
        coverage_p=p_value,
        pulls=int(pulls.size),
        pull_mean=float(pulls.mean()) if pulls.size else None,
        pull_sd=float(pulls.std(ddof=1)) if pulls.size > 1 else None,
        pull_p=normal_p_value(pulls),
    )


def normal_p_value(pulls: NDArray[np.float64]) -> float | None:
    """Return the probability of pulls so far from standard normal ones (Kolmogorov-Smirnov); None below five."""
    if pulls.size < 5:
        return None
    from scipy.stats import kstest  # noqa: PLC0415 - loads when used

    return float(kstest(pulls, "norm").pvalue)


def binomial_interval(hits: int, of: int) -> tuple[float, float]:
    """Return the 95 % interval of Clopper and Pearson for a probability.

    Examples
    --------
    >>> low, high = binomial_interval(95, 100)
    >>> round(low, 3), round(high, 3)
    (0.887, 0.984)

    """
    from scipy.special import betaincinv  # noqa: PLC0415 - loads when used

    low = float(betaincinv(hits, of - hits + 1, 0.025)) if hits else 0.0
    high = float(betaincinv(hits + 1, of - hits, 0.975)) if hits < of else 1.0
    return low, high


def _coverage(hits: int, of: int) -> tuple[float | None, float | None, float | None]:
    if not of:
        return None, None, None
    from scipy.stats import binomtest  # noqa: PLC0415 - loads when used

    return (*binomial_interval(hits, of), float(binomtest(hits, of, NOMINAL).pvalue))
