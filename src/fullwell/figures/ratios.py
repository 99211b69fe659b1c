"""A ratio in its three dresses: plain, in decibel, in stops. Errors and intervals are those of its logarithm."""

import math
from dataclasses import dataclass
from typing import Final

from fullwell.units import DECIBEL, ONE, STOP, Measured, student_975

_DECIBEL: Final = 20.0 / math.log(10.0)
_STOPS: Final = 1.0 / math.log(2.0)


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


def ratio(value: float, relative_error: float, dof: float | None) -> Ratio:
    """Return a ratio above zero from the standard error of its natural logarithm.

    Examples
    --------
    >>> round(ratio(1000.0, 0.01, None).decibel.value, 9)
    60.0

    """
    logarithm = math.log(value)
    reach = student_975(dof) * relative_error
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
