"""Numbers as people read them: as many digits as the uncertainty allows, units with their proper signs.

Which function: `show` for a row, `show_value` where the uncertainty stands elsewhere, `show_interval` for the 95 %
interval, `show_unit` for a unit, `show_plain` for a number that is only context (an ISO, an exposure).
"""

import math
from typing import Final

from fullwell.units import Measured

MISSING: Final = "\N{EM DASH}"
_MINUS: Final = "\N{MINUS SIGN}"
_GROUP: Final = "\N{NARROW NO-BREAK SPACE}"
_SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_FREE_DIGITS: Final = 4
_LARGEST_PLAIN_EXPONENT: Final = 6
_SMALLEST_PLAIN_EXPONENT: Final = -4


def show(measured: Measured, flags: tuple[str, ...] = ()) -> str:
    """Return value and standard error without the unit, to two significant digits of the error.

    Where the value is only a limit (``upper-limit``, ``lower-bound``) the limit is shown.

    Examples
    --------
    >>> show(Measured.normal(2.34567, 0.0123, "DN"))
    '2.346 ± 0.012'
    >>> show(Measured(value=0.0, unit="DN", ci95=(0.0, 0.1234)), ("upper-limit",))
    '≤ 0.12 (95 %)'
    >>> show(Measured.exact(1023, "DN"))
    '1023'

    """
    if not math.isfinite(measured.value):
        return MISSING
    if "upper-limit" in flags and measured.ci95 is not None and measured.std_error is None:
        return f"≤ {_significant(measured.ci95[1], 2 if measured.value <= 0.0 else 3)} (95 %)"
    if "lower-bound" in flags:
        return f"≥ {show_value(measured)}"
    error = _usable(measured.std_error)
    if error is None:
        return show_value(measured)
    place = _error_place(error)
    exponent = _exponent(measured.value, error)
    if exponent is None:
        return f"{_fixed(measured.value, place)} ± {_fixed(error, place)}"
    scaled, scaled_error = _shifted(measured.value, exponent), _shifted(error, exponent)
    power = str(exponent).translate(_SUPERSCRIPTS)
    return f"({_fixed(scaled, place - exponent)} ± {_fixed(scaled_error, place - exponent)}) × 10{power}"


def show_value(measured: Measured) -> str:
    """Return the value alone, to the digits its standard error allows (four digits where there is none).

    Examples
    --------
    >>> show_value(Measured.normal(5832.7, 41.2, "e-"))
    '5833'
    >>> show_value(Measured.exact(1.672e-4, "1"))  # as with an error
    '1.672 × 10⁻⁴'

    """
    if not math.isfinite(measured.value):
        return MISSING
    error = _usable(measured.std_error)
    if error is None:
        whole = measured.value == round(measured.value)
        return show_plain(measured.value) if whole else _significant(measured.value, _FREE_DIGITS, all_digits=True)
    exponent = _exponent(measured.value, error)
    if exponent is None:
        return _fixed(measured.value, _error_place(error))
    power = str(exponent).translate(_SUPERSCRIPTS)
    return f"{_fixed(_shifted(measured.value, exponent), _error_place(error) - exponent)} × 10{power}"


def show_interval(measured: Measured) -> str:
    """Return the 95 % interval to the digits its width allows.

    Examples
    --------
    >>> show_interval(Measured.normal(2.34567, 0.0123, "DN"))
    '2.322 to 2.370'

    """
    if measured.ci95 is None or not all(math.isfinite(end) for end in measured.ci95):
        return MISSING
    low, high = measured.ci95
    width = high - low
    if width <= 0.0:
        return show_plain(low)
    place = _error_place(_usable(measured.std_error) or width / 4.0)
    exponent = _exponent(max(abs(low), abs(high)), width)
    if exponent is None:
        return f"{_fixed(low, place)} to {_fixed(high, place)}"
    power = str(exponent).translate(_SUPERSCRIPTS)
    ends = [_fixed(_shifted(end, exponent), place - exponent) for end in (low, high)]
    return f"({ends[0]} to {ends[1]}) × 10{power}"


def show_plain(value: float | None) -> str:
    """Return a number that carries no uncertainty: whole numbers whole, others to four significant digits.

    Examples
    --------
    >>> show_plain(12345.0), show_plain(0.1705), show_plain(None)
    ('12\N{NARROW NO-BREAK SPACE}345', '0.1705', '—')

    """
    if value is None or not math.isfinite(value):
        return MISSING
    if value == round(value) and abs(value) < 1e9:
        return _fixed(value, 0)
    return _significant(value, _FREE_DIGITS)


def show_change(value: float) -> str:
    """Return a difference with its sign, to two significant digits.

    Examples
    --------
    >>> show_change(-0.4789), show_change(99.9), show_change(9.5e-06), show_change(0.0)
    ('\N{MINUS SIGN}0.48', '+100', '+9.5 × 10⁻⁶', '0')

    """
    return _signed(_significant(abs(value), 2), value)


def show_signed(value: float, decimals: int = 1) -> str:
    """Return a number with its sign, to some decimals.

    Examples
    --------
    >>> show_signed(-1.26), show_signed(0.04)
    ('\N{MINUS SIGN}1.3', '+0.0')

    """
    return _signed(f"{abs(value):.{decimals}f}", value)


def show_unit(unit: str) -> str:
    """Return a unit with superscripts; nothing for the unit 1.

    Examples
    --------
    >>> show_unit("DN^2"), show_unit("DN/e-"), show_unit("e-^2"), show_unit("1")
    ('DN²', 'DN/e⁻', '(e⁻)²', '')

    """
    if unit == "1":
        return ""
    text = unit.replace("e-^2", "(e-)^2").replace("e-", "e⁻").replace("um", "µm")
    return text.replace("^2", "²").replace("^4", "⁴")


def show_exposure(seconds: float | None) -> str:
    """Return an exposure time in the unit people use for it.

    Examples
    --------
    >>> show_exposure(0.002867), show_exposure(1.5), show_exposure(2.5e-05)
    ('2.867 ms', '1.5 s', '25 µs')

    """
    if seconds is None or not math.isfinite(seconds):
        return MISSING
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0 or unit == "µs" or seconds == 0.0:
            return f"{seconds * factor:.4g} {unit}"
    return MISSING


def show_iso(iso: float | None) -> str:
    """Return how an ISO is called, also where nobody knows it."""
    return "unknown ISO" if iso is None else f"ISO {iso:g}"


def _signed(magnitude: str, value: float) -> str:
    return magnitude if value == 0.0 else f"{_MINUS if value < 0.0 else '+'}{magnitude}"


def _usable(error: float | None) -> float | None:
    return error if error is not None and math.isfinite(error) and error > 0.0 else None


def _error_place(error: float) -> int:
    """Return the power of ten of the second significant digit of an error, after rounding to two digits."""
    return int(f"{error:.1e}".partition("e")[2]) - 1


def _exponent(value: float, error: float) -> int | None:
    """Return the power of ten to write in front, None where plain digits read better."""
    largest = max(abs(value), error)
    exponent = int(f"{largest:.1e}".partition("e")[2])
    plain = _SMALLEST_PLAIN_EXPONENT < exponent < _LARGEST_PLAIN_EXPONENT
    return None if plain else exponent


def _shifted(value: float, exponent: int) -> float:
    """Return value / 10**exponent without a power that underflows or overflows."""
    return float(f"{value:.17e}".partition("e")[0]) * 10.0 ** (int(f"{value:.17e}".partition("e")[2]) - exponent)


def _fixed(value: float, place: int) -> str:
    """Return a number rounded at a power of ten, thousands grouped from five digits on, with a true minus sign."""
    text = f"{value:.{-place}f}" if place < 0 else f"{round(value, -place):.0f}"
    digits = text.lstrip("-")
    whole, point, fraction = digits.partition(".")
    if len(whole) > _FREE_DIGITS:
        whole = f"{int(whole):,}".replace(",", _GROUP)
    negative = text.startswith("-") and any(digit in "123456789" for digit in digits)
    return (_MINUS if negative else "") + whole + point + fraction


def _significant(value: float, digits: int, *, all_digits: bool = False) -> str:
    """Return a number to some significant digits, trailing zeros dropped unless all digits are wanted."""
    if value == 0.0:
        return "0"
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    smallest = _SMALLEST_PLAIN_EXPONENT if all_digits else _SMALLEST_PLAIN_EXPONENT - 1
    if smallest < exponent < _LARGEST_PLAIN_EXPONENT:
        text = _fixed(value, exponent - digits + 1)
        return text if all_digits else _trimmed(text)
    shown = mantissa if all_digits else _trimmed(mantissa)
    return f"{shown.replace('-', _MINUS)} × 10{str(exponent).translate(_SUPERSCRIPTS)}"


def _trimmed(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text
