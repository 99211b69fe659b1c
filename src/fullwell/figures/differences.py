"""Two measurements of one thing: their difference, and how often chance alone makes one as large."""

import math
from dataclasses import dataclass

from fullwell.figures.results import Row
from fullwell.units import Measured, combined_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """One figure less another.

    Parameters
    ----------
    measured
        The difference; its standard error is None where one of the two has none, or where their errors are not
        independent.
    ratio
        The figure over the other, None where that one is 0 [1].
    statistic
        The difference over its standard error; None without one [1].
    p_value
        Chance that figures of one truth differ by at least as much (Student's t, two sided); None without an error.

    """

    measured: Measured
    ratio: float | None
    statistic: float | None
    p_value: float | None


def difference(figure: Measured, reference: Measured, *, independent: bool = True) -> Difference:
    """Return a figure less a reference in the same unit (Welch's test).

    Parameters
    ----------
    figure, reference
        With their standard errors and degrees of freedom.
    independent
        Whether their errors are: those of figures from the same frames are not, and the difference is then told
        without an error.

    Examples
    --------
    >>> one = difference(Measured.normal(1.2, 0.3, "DN"), Measured.normal(0.2, 0.4, "DN"))
    >>> one.statistic, round(one.p_value, 4)
    (2.0, 0.0455)

    """
    value = figure.value - reference.value
    ratio = None if reference.value == 0.0 else figure.value / reference.value
    if not independent or figure.std_error is None or reference.std_error is None:
        return Difference(measured=Measured.exact(value, figure.unit), ratio=ratio, statistic=None, p_value=None)
    error = math.hypot(figure.std_error, reference.std_error)
    if error == 0.0:
        return Difference(measured=Measured.exact(value, figure.unit), ratio=ratio, statistic=None, p_value=None)
    dof = combined_dof((figure.std_error, figure.dof), (reference.std_error, reference.dof))
    statistic = value / error
    return Difference(
        measured=Measured.student(value, error, dof, figure.unit),
        ratio=ratio,
        statistic=statistic,
        p_value=two_sided(statistic, dof),
    )


def row_difference(figure: Row, reference: Row, *, independent: bool = True) -> Difference | None:
    """Return a row less a reference; None where both are bounds on one side, whose difference bounds nothing."""
    if any(flag in figure.flags and flag in reference.flags for flag in ("lower-bound", "upper-limit")):
        return None
    return difference(figure.measured, reference.measured, independent=independent)


def two_sided(statistic: float, dof: float | None) -> float:
    """Return the chance of a Student's t at least this far from 0; ``dof`` None is the normal.

    Examples
    --------
    >>> round(two_sided(-2.0, 10.0), 4)
    0.0734

    """
    if dof is None:
        return math.erfc(abs(statistic) / math.sqrt(2.0))
    from scipy.special import stdtr  # noqa: PLC0415 - `fullwell --help` must not load SciPy

    return 2.0 * float(stdtr(dof, -abs(statistic)))
