"""The same figure in electrons and in volts.

Electrons need a measured system gain, whose error joins that of the figure; volts need a declared voltage swing, which
is exact by definition, so figures in volts are model-based.
"""

import math
from typing import Final

from fullwell.units import (
    DN,
    DN2,
    DN_PER_SECOND,
    ELECTRON,
    ELECTRON2,
    ELECTRON_PER_SECOND,
    VOLT,
    VOLT_PER_SECOND,
    Measured,
    combined_dof,
    student_975,
)

_ELECTRON_UNITS: Final = ((DN, ELECTRON, 1), (DN2, ELECTRON2, 2), (DN_PER_SECOND, ELECTRON_PER_SECOND, 1))
_VOLT_UNITS: Final = ((DN, VOLT, 1), (DN2, "V^2", 2), (DN_PER_SECOND, VOLT_PER_SECOND, 1))


def to_electrons(measured_dn: Measured, system_gain: Measured) -> Measured:
    """Return a figure in DN, DN^2 or DN/s divided by the system gain, or by its square.

    Parameters
    ----------
    measured_dn
        The figure.
    system_gain
        K, above zero and from other data than the figure: the two errors are taken as independent [DN/e-].

    Returns
    -------
    Measured
        Relative errors added in squares, their degrees of freedom combined by Welch and Satterthwaite. An interval that
        was asymmetric stays so: the reach to either side is combined with that of the system gain (MOVER). The ends of
        a bracket, within which nothing is likelier than anything else, move by the whole of it: the truth may well lie
        on one.

    Raises
    ------
    ValueError
        Where the system gain is not positive, or the unit is not one in DN.

    """
    unit, power = _converted(measured_dn.unit, _ELECTRON_UNITS)
    if system_gain.value <= 0.0:
        raise ValueError("electrons need a system gain above zero")
    factor = system_gain.value**-power
    value = measured_dn.value * factor
    system_gain_error = power * abs(value) * (system_gain.std_error or 0.0) / system_gain.value
    if measured_dn.std_error is None:
        return Measured(
            value=value,
            unit=unit,
            dof=measured_dn.dof,
            ci95=_combined_interval(measured_dn, value, factor, student_975(system_gain.dof) * system_gain_error),
        )
    own_error = measured_dn.std_error * factor
    error = math.hypot(own_error, system_gain_error)
    dof = combined_dof((own_error, measured_dn.dof), (system_gain_error, system_gain.dof))
    if _is_student(measured_dn):
        return Measured.student(value, error, dof, unit)
    reach = student_975(system_gain.dof) * system_gain_error
    if _is_bracket(measured_dn):
        interval = _moved_ends(measured_dn, factor, reach / abs(value) if value else 0.0)
    else:
        interval = _combined_interval(measured_dn, value, factor, reach)
    return Measured(value=value, unit=unit, std_error=error, dof=dof, ci95=interval)


def to_volts(measured_dn: Measured, volts_per_dn: float) -> Measured:
    """Return a figure in DN, DN^2 or DN/s in volts; ``volts_per_dn`` is exact by definition (swing / white level).

    Examples
    --------
    >>> to_volts(Measured.normal(0.064, 0.001, DN_PER_SECOND), 0.459 / 1023).unit
    'V/s'

    """
    unit, power = _converted(measured_dn.unit, _VOLT_UNITS)
    return measured_dn.scaled(volts_per_dn**power, unit)


def _converted(unit: str, table: tuple[tuple[str, str, int], ...]) -> tuple[str, int]:
    for source, target, power in table:
        if unit == source:
            return target, power
    raise ValueError(f"a figure in {unit} cannot be converted; give one in DN, DN^2 or DN/s")


def _is_student(measured: Measured) -> bool:
    """Return whether the interval is Student's own, symmetric about the value."""
    if measured.ci95 is None or measured.std_error is None:
        return measured.ci95 is None
    half = student_975(measured.dof) * measured.std_error
    return all(
        math.isclose(end, measured.value + side * half, rel_tol=0.0, abs_tol=1e-9 * half)
        for end, side in zip(measured.ci95, (-1.0, 1.0), strict=True)
    )


def _is_bracket(measured: Measured) -> bool:
    """Return whether the error is that of a uniform law over the interval."""
    if measured.ci95 is None or measured.std_error is None:
        return False
    low, high = measured.ci95
    return math.isclose(measured.std_error, (high - low) / math.sqrt(12.0), rel_tol=1e-9)


def _moved_ends(measured: Measured, factor: float, reach: float) -> tuple[float, float] | None:
    """Return an interval whose ends move outwards by a share of their own."""
    if measured.ci95 is None:
        return None
    low, high = (end * factor for end in measured.ci95)
    return low - reach * abs(low), high + reach * abs(high)


def _combined_interval(
    measured: Measured, value: float, factor: float, system_gain_reach: float
) -> tuple[float, float] | None:
    if measured.ci95 is None:
        return None
    below = math.hypot((measured.value - measured.ci95[0]) * factor, system_gain_reach)
    above = math.hypot((measured.ci95[1] - measured.value) * factor, system_gain_reach)
    low = value - below
    return (max(low, 0.0) if measured.ci95[0] >= 0.0 else low), value + above
