"""Values with their uncertainty and unit: nothing leaves a fit without them.

Which constructor: `Measured.student` for an estimate with degrees of freedom, `Measured.normal` for one whose
degrees of freedom are so many that the normal holds, `Measured.interval` where the interval is asymmetric,
`square_root` for a standard deviation whose variance was estimated, `Measured.exact` for a published figure
whose authors gave no uncertainty.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, Self

DN: Final = "DN"
DN2: Final = "DN^2"
ELECTRON: Final = "e-"
ELECTRON2: Final = "e-^2"
VOLT: Final = "V"
DECIBEL: Final = "dB"
STOP: Final = "EV"
ONE: Final = "1"
PERCENT: Final = "%"
PERCENT2: Final = "%^2"
DN_PER_ELECTRON: Final = "DN/e-"
DN_PER_SECOND: Final = "DN/s"
ELECTRON_PER_SECOND: Final = "e-/s"
VOLT_PER_SECOND: Final = "V/s"

_NORMAL_975: Final = 1.959963984540054
_MANY_DOF: Final = 1e4
"""Degrees of freedom above which the normal holds."""
_FEW_DOF: Final = 8.0
"""Degrees of freedom below which an error may be small by chance."""


def student_975(dof: float | None) -> float:
    """Return the 97.5 % point of Student's t for ``dof`` degrees of freedom (None: the normal)."""
    if dof is None:
        return _NORMAL_975
    from scipy.special import stdtrit  # noqa: PLC0415 - `fullwell --help` must not load SciPy

    return float(stdtrit(dof, 0.975))


def welch_dof(*parts: tuple[float, float | None]) -> float | None:
    """Return the degrees of freedom of a mean of like errors (Welch and Satterthwaite).

    Parameters
    ----------
    *parts
        Standard error and degrees of freedom (None or infinity: many) of each part.

    Returns
    -------
    float or None
        None where they are so many, above 10^4, that the normal holds.

    Examples
    --------
    >>> welch_dof((1.0, 4.0), (0.0, None))
    4.0
    >>> welch_dof((1.0, None), (1.0, None)) is None
    True

    """
    total = sum(error**2 for error, _ in parts)
    doubt = sum(error**4 / dof for error, dof in parts if dof is not None)
    return None if doubt * _MANY_DOF < total**2 or doubt == 0.0 else total**2 / doubt


def combined_dof(*parts: tuple[float, float | None]) -> float | None:
    """Return the degrees of freedom of a sum of errors, which is known no better than any of them.

    Those of `welch_dof` are too many where an error of few degrees of freedom came out small by chance beside one that
    is known well: of 1 beside one of a third of its size, 87 % of the intervals are true. Where its own interval would
    be the wider one, the sum is given the degrees of freedom that make its interval as wide; 95 % are true then.

    Parameters
    ----------
    *parts
        Standard error and degrees of freedom (None or infinity: many) of each part.

    Examples
    --------
    >>> round(combined_dof((1.0, 1.0), (1.0, None)) or 0.0, 2)
    1.18

    """
    dof = welch_dof(*parts)
    few = [part for part in parts if part[0] > 0.0 and part[1] is not None and part[1] < min(_FEW_DOF, dof or math.inf)]
    total = math.hypot(*(error for error, _ in parts))
    widest = max((student_975(own) * error / total for error, own in few), default=0.0)
    if widest <= student_975(dof):
        return dof
    from scipy.special import stdtridf  # noqa: PLC0415 - `fullwell --help` must not load SciPy

    return float(stdtridf(0.975, widest))


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A value, one standard error of it, its degrees of freedom and its 95 % interval.

    Parameters
    ----------
    value
        The estimate, in ``unit``.
    unit
        Unit from this module's vocabulary.
    std_error
        One standard error in the same unit; None where nobody knows it.
    dof
        Degrees of freedom of the standard error; None means so many that the normal holds.
    ci95
        Lower and upper end of the 95 % interval; None where unknown.

    """

    value: float
    unit: str
    std_error: float | None = None
    dof: float | None = None
    ci95: tuple[float, float] | None = None

    @classmethod
    def exact(cls, value: float, unit: str) -> Self:
        """Return a value without an uncertainty: a published figure, a code read from a file."""
        return cls(value=float(value), unit=unit)

    @classmethod
    def normal(cls, value: float, std_error: float, unit: str) -> Self:
        """Return an estimate with a normal interval."""
        return cls.student(value, std_error, None, unit)

    @classmethod
    def student(cls, value: float, std_error: float, dof: float | None, unit: str) -> Self:
        """Return an estimate with the interval of Student's t."""
        half = student_975(dof) * std_error
        return cls(
            value=float(value),
            unit=unit,
            std_error=float(std_error),
            dof=None if dof is None else float(dof),
            ci95=(float(value - half), float(value + half)),
        )

    @classmethod
    def interval(cls, value: float, std_error: float | None, ci95: tuple[float, float], unit: str) -> Self:
        """Return an estimate with an interval of its own."""
        return cls(value=float(value), unit=unit, std_error=std_error, ci95=(float(ci95[0]), float(ci95[1])))

    def scaled(self, factor: float, unit: str) -> Self:
        """Return the same measurement in another unit; ``factor`` is exact and positive."""
        return replace(
            self,
            value=self.value * factor,
            unit=unit,
            std_error=None if self.std_error is None else self.std_error * factor,
            ci95=None if self.ci95 is None else (self.ci95[0] * factor, self.ci95[1] * factor),
        )


def square_root(variance: Measured, unit: str) -> Measured:
    """Return the standard deviation of an estimated variance, its interval mapped from variance space.

    Parameters
    ----------
    variance
        The variance, signed, in the squared unit, with its standard error and interval.
    unit
        Unit of the square root.

    Returns
    -------
    Measured
        Where the variance is at or below zero: value 0, no standard error, and an interval from 0 to the upper limit.

    """
    ci95 = (
        None
        if variance.ci95 is None
        else (math.sqrt(max(variance.ci95[0], 0.0)), math.sqrt(max(variance.ci95[1], 0.0)))
    )
    if variance.value <= 0.0:
        return Measured(value=0.0, unit=unit, dof=variance.dof, ci95=None if ci95 is None else (0.0, ci95[1]))
    value = math.sqrt(variance.value)
    std_error = None if variance.std_error is None else variance.std_error / (2.0 * value)
    return Measured(value=value, unit=unit, std_error=std_error, dof=variance.dof, ci95=ci95)
