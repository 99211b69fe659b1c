"""Where an axis is marked, and with which words: round numbers, at least two of them, all between its ends."""

import math
from collections.abc import Sequence
from typing import Final

_STEPS: Final = (1.0, 2.0, 2.5, 5.0, 10.0)
_WHOLE_STEPS: Final = (1.0, 2.0, 5.0, 10.0)
_FEW_DECADES: Final = 50.0
"""Ratio of ends up to which a logarithmic axis is marked at 1, 2 and 5."""
_SLACK: Final = 1e-9
_PLAIN: Final = 1e6
"""Numbers below it stand on a linear axis as they are."""
_SMALL: Final = 1e-4


def linear_ticks(low: float, high: float, *, most: int, whole: bool = False) -> list[float]:
    """Return round numbers from low to high, at most ``most`` steps apart.

    Parameters
    ----------
    low, high
        Ends.
    most
        Steps between the first and the last number, at least 3.
    whole
        Whether only whole numbers may be marked.

    Examples
    --------
    >>> linear_ticks(-0.2, 10.3, most=5)
    [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]

    """
    decade = 10.0 ** (math.floor(math.log10((high - low) / most)) if high > low else 0)
    if whole:
        decade = max(decade, 1.0)
    for step in (scale * decade for scale in (*(_WHOLE_STEPS if whole else _STEPS), 20.0, 50.0, 100.0)):
        slack = _SLACK * (high - low) / step
        first, last = math.ceil(low / step - slack), math.floor(high / step + slack)
        if last - first <= most:
            return [round(index * step, 12 - math.floor(math.log10(step))) for index in range(first, last + 1)]
    return []


def linear_words(ticks: Sequence[float]) -> list[str]:
    """Return numbers with as many places as they need, all alike; beyond a million and below 0.0001 with a power.

    Examples
    --------
    >>> linear_words([-0.5, 0.0, 0.5]), linear_words([0.0, 2.5e7])
    (['\N{MINUS SIGN}0.5', '0.0', '0.5'], ['0', '2.5·10^{7}'])

    """
    largest = max((abs(tick) for tick in ticks), default=0.0)
    if largest >= _PLAIN or 0.0 < largest < _SMALL:
        return [_power(tick) for tick in ticks]
    places = next((n for n in range(10) if all(abs(tick - round(tick, n)) <= _SLACK * largest for tick in ticks)), 10)
    return [minus(f"{tick:.{places}f}") for tick in ticks]


def log_ticks(low: float, high: float, *, most: int) -> list[float]:
    """Return decades between positive ends; 1, 2 and 5 of each where they are few; round numbers where none are."""
    first, last = math.ceil(math.log10(low) - _SLACK), math.floor(math.log10(high) + _SLACK)
    if high < _FEW_DECADES * low or last <= first:
        fine = [scale * 10.0**decade for decade in range(first - 1, last + 1) for scale in (1.0, 2.0, 5.0)]
        fine = [tick for tick in fine if low * (1.0 - _SLACK) <= tick <= high * (1.0 + _SLACK)]
        return fine if len(fine) > 1 else linear_ticks(low, high, most=3)
    stride = -(-(last - first + 1) // most)
    return [10.0**decade for decade in range(first, last + 1) if decade % stride == 0 or last - first < stride]


def small_log_ticks(low: float, high: float) -> list[float]:
    """Return 2 to 9 of every decade between positive ends; none where there are many decades."""
    first, last = math.floor(math.log10(low)), math.floor(math.log10(high))
    if last - first > 11:
        return []
    every = (scale * 10.0**decade for decade in range(first, last + 1) for scale in range(2, 10))
    return [tick for tick in every if low <= tick <= high]


def log_words(ticks: Sequence[float]) -> list[str]:
    """Return numbers plain from 0.001 to below 10 000, else with a power of ten.

    Examples
    --------
    >>> log_words([0.0005, 0.01, 500.0, 1e5])
    ['5·10^{\N{MINUS SIGN}4}', '0.01', '500', '10^{5}']

    """
    return [f"{tick:g}" if 1e-3 <= tick < 1e4 else _power(tick) for tick in ticks]


def power_words(ticks: Sequence[float]) -> list[str]:
    """Return every number with a power of ten.

    Examples
    --------
    >>> power_words([0.1, 1.0])
    ['10^{\N{MINUS SIGN}1}', '10^{0}']

    """
    return [_power(tick) for tick in ticks]


def minus(text: str) -> str:
    """Return a number with a minus sign that is as wide as a plus."""
    return text.replace("-", "\N{MINUS SIGN}")


def _power(value: float) -> str:
    if value == 0.0:
        return "0"
    mantissa, _, exponent = f"{value:.6e}".partition("e")
    factor = f"{float(mantissa):g}"
    power = f"10^{{{minus(str(int(exponent)))}}}"
    return power if factor == "1" else minus(f"{factor}·{power}")
