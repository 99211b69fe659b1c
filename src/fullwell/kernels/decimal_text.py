"""Numbers as decimal text of twelve significant digits, line by line, as ``format(x, ".12g")`` writes them.

The digits are those of x times a power of ten, rounded: in the last one a number that lies on the verge of two may go
either way.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

DIGITS: Final = 12
LONGEST: Final = DIGITS + 8
"""Bytes that one number and what follows it take at most: sign, point, four of zeros or of the exponent, comma."""

_POWERS: Final = np.array([float(f"1e{power}") for power in range(-308, 309)])
_FIRST: Final = 308
_LOG10_2: Final = 19728
"""Of 65,536; so near that no decade is out by more than one."""
_FULL: Final = 10**DIGITS
_SMALLEST: Final = 1e-290
_LIFT: Final = 200
_ZERO, _POINT, _MINUS, _PLUS, _COMMA, _LINE, _E = (ord(one) for one in "0.-+,\ne")
_FOUR: Final = (_ZERO + np.arange(10000)[:, np.newaxis] // (1000, 100, 10, 1) % 10).astype(np.uint8)
_NAN: Final = np.frombuffer(b"nan", np.uint8)
_INF: Final = np.frombuffer(b"inf", np.uint8)


@njit(cache=True, nogil=True, error_model="numpy")
def _decade(size: float, word: NDArray[np.float64]) -> int:
    """Return e of 10^e <= size < 10^(e + 1), from the exponent of two."""
    word[0] = size
    twos = int(word.view(np.int64)[0] >> 52) - 1023
    decade = (twos * _LOG10_2) >> 16
    if size < _POWERS[_FIRST + decade]:
        return decade - 1
    return decade + 1 if size >= _POWERS[_FIRST + decade + 1] else decade


@njit(cache=True, nogil=True, error_model="numpy")
def _scaled(size: float, word: NDArray[np.float64]) -> tuple[int, int]:
    """Return the twelve digits of a number above zero as a whole one, and the power of ten of the first."""
    lift = 0
    if size < _SMALLEST:
        size, lift = size * _POWERS[_FIRST + _LIFT], _LIFT
    decade = _decade(size, word)
    shift = DIGITS - 1 - decade
    scaled = size * _POWERS[_FIRST + shift] if shift >= 0 else size / _POWERS[_FIRST - shift]
    whole = int(scaled + 0.5)
    if whole >= _FULL:
        whole, decade = whole // 10, decade + 1
    return whole, decade - lift


@njit(cache=True, nogil=True, error_model="numpy")
def _put_digits(whole: int, out: NDArray[np.uint8], at: int) -> None:
    """Write twelve digits."""
    first = whole // 100000000
    rest = whole - first * 100000000
    second = rest // 10000
    third = rest - second * 10000
    for k in range(4):
        out[at + k] = _FOUR[first, k]
    for k in range(4):
        out[at + 4 + k] = _FOUR[second, k]
    for k in range(4):
        out[at + 8 + k] = _FOUR[third, k]


@njit(cache=True, nogil=True, error_model="numpy")
def _put_exponent(decade: int, out: NDArray[np.uint8], at: int) -> int:
    """Write an exponent of two digits or more and return where it ends."""
    out[at], out[at + 1] = _E, (_MINUS if decade < 0 else _PLUS)
    size, at = abs(decade), at + 2
    if size >= 100:
        out[at] = _ZERO + size // 100
        at += 1
    out[at], out[at + 1] = _ZERO + size // 10 % 10, _ZERO + size % 10
    return at + 2


@njit(cache=True, nogil=True, error_model="numpy")
def _put_number(value: float, word: NDArray[np.float64], out: NDArray[np.uint8], at: int) -> int:
    """Write a number and return where it ends."""
    if value < 0.0:
        out[at] = _MINUS
        at += 1
    size = abs(value)
    if not 0.0 < size < np.inf:
        return _put_special(size, out, at)
    whole, decade = _scaled(size, word)
    plain = -4 <= decade < DIGITS
    before = decade + 1 if plain else 1
    if before <= 0:
        out[at], out[at + 1] = _ZERO, _POINT
        at += 2
        for _ in range(-before):
            out[at] = _ZERO
            at += 1
        _put_digits(whole, out, at)
        end = at + DIGITS
    else:
        _put_digits(whole, out, at + 1)
        for k in range(before):
            out[at + k] = out[at + k + 1]
        out[at + before] = _POINT
        end = at + DIGITS + 1
    while out[end - 1] == _ZERO:
        end -= 1
    if out[end - 1] == _POINT:
        end -= 1
    return end if plain else _put_exponent(decade, out, end)


@njit(cache=True, nogil=True, error_model="numpy")
def _put_special(size: float, out: NDArray[np.uint8], at: int) -> int:
    """Write zero, infinity or what is not a number, and return where it ends."""
    if size == 0.0:
        out[at] = _ZERO
        return at + 1
    letters = _INF if size == np.inf else _NAN
    for k in range(3):
        out[at + k] = letters[k]
    return at + 3


@njit(cache=True, nogil=True, error_model="numpy")
def put_lines(values: NDArray[np.float64], out: NDArray[np.uint8]) -> int:
    """Write rows of numbers with commas between them, a line each, and return how many bytes that took.

    Parameters
    ----------
    values
        Shape (rows, columns).
    out
        Filled from its start; `LONGEST` bytes a number are enough.

    """
    word = np.empty(1)
    at = 0
    for r in range(values.shape[0]):
        for c in range(values.shape[1]):
            at = _put_number(values[r, c], word, out, at)
            out[at] = _COMMA
            at += 1
        out[at - 1] = _LINE
    return at
