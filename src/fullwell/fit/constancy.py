"""Is a figure the same everywhere: at every ISO, in every region (METHOD 5.6)."""

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from fullwell.units import DN2, Measured


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
    raise NotImplementedError


def equal_variances(variances: ArrayLike, dof: ArrayLike, *, inflation: ArrayLike = 1.0, unit: str = DN2) -> Constancy:
    """Test whether regions have the same variance (Bartlett).

    Parameters
    ----------
    variances
        Independent variance estimates, any shape [``unit``].
    dof
        Their degrees of freedom, of the same shape or one for all; estimates without any are left out.
    inflation
        By what the variance of an estimate exceeds that of chi-square (rows that share noise, telegraph pixels:
        METHOD 1.8, 3.6), of the same shape or one for all.
    unit
        Of the variances.

    """
    raise NotImplementedError
