"""A ratio in its three dresses: plain, in decibel, in stops. Errors and intervals are those of its logarithm."""

import math
from dataclasses import dataclass, replace
from typing import Final, Self

from fullwell.units import DECIBEL, ONE, STOP, Measured, student_975

_DECIBEL: Final = 20.0 / math.log(10.0)
_STOPS: Final = 1.0 / math.log(2.0)
_FARTHEST: Final = math.log(1e20)
"""Reach of an interval to either side, 400 dB, from where on it is no interval."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """One ratio, thrice.

    Parameters
    ----------
    plain
        The ratio [1].
    decibel
        20 log10 of it [dB].
    stops
        log2 of it [EV].

    """

    plain: Measured
    decibel: Measured
    stops: Measured

    def between(self, low: Self, high: Self) -> Self:
        """Return the same ratio with an interval from the lower end of one to the upper end of another."""

        def reaching(own: Measured, least: Measured, most: Measured) -> Measured:
            if least.ci95 is None or most.ci95 is None:
                return own
            return replace(own, ci95=(least.ci95[0], most.ci95[1]))

        return replace(
            self,
            plain=reaching(self.plain, low.plain, high.plain),
            decibel=reaching(self.decibel, low.decibel, high.decibel),
            stops=reaching(self.stops, low.stops, high.stops),
        )


def ratio(value: float, relative_error: float, dof: float | None) -> Ratio:
    """Return a ratio above zero from the standard error of its natural logarithm.

    Raises
    ------
    ValueError
        Where that error is so large that nothing is told of the ratio.

    Examples
    --------
    >>> round(ratio(1000.0, 0.01, None).decibel.value, 9)
    60.0

    """
    logarithm = math.log(value)
    reach = student_975(dof) * relative_error
    if reach > _FARTHEST:
        raise ValueError(f"a ratio of {value:g} whose logarithm is known to {relative_error:.3g} tells nothing")
    plain = Measured(
        value=value,
        unit=ONE,
        std_error=value * relative_error,
        dof=dof,
        ci95=(value * math.exp(-reach), value * math.exp(reach)),
    )
    return Ratio(
        plain=plain,
        decibel=Measured.student(_DECIBEL * logarithm, _DECIBEL * relative_error, dof, DECIBEL),
        stops=Measured.student(_STOPS * logarithm, _STOPS * relative_error, dof, STOP),
    )
