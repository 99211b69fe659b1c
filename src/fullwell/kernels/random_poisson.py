"""Poisson numbers, exact at every mean.

Inversion by sequential search below a mean of 10; above, a rounded normal number put right by acceptance and rejection
(Ahrens and Dieter, algorithm PD, ACM TOMS 8, 1982, made for means of at least 10; here with exact probabilities in
place of its series). The normal number takes 40 bits of place from a pixel's word, and 13 bits begin the uniform number
that accepts it: nearly always they decide, else a further draw brings the rest.
"""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.random_normal import layer_candidate, settled
from fullwell.kernels.random_words import CHUNK, FloatArray, Words, drawn, fill_words, from_one, unit

_SMALL_MEAN: Final = 10.0
_LONGEST_SEARCH: Final = 200
_FACTORIALS: Final = np.array([math.factorial(k) for k in range(10)], dtype=np.float64)


@njit(cache=True, inline="always")
def _place(word: np.uint64) -> float:
    """Return the upper 40 bits of a word as a number strictly between 0 and 1."""
    return from_one(word >> np.uint64(24) << np.uint64(12)) - (1.0 - 2.0**-41)


@njit(cache=True, inline="always")
def _beginning(word: np.uint64) -> float:
    """Return 13 bits that nothing else uses as a number from 0 to below 1: the uniform number at least."""
    return from_one((word >> np.uint64(11) & np.uint64(0x1FFF)) << np.uint64(39)) - 1.0


@njit(cache=True, inline="always", error_model="numpy")
def _squeeze(mean: float, normal_number: float, u: float) -> tuple[float, bool]:
    """Return PD's candidate, a rounded normal number, and whether its steps I and S accept it at once."""
    candidate = np.floor(mean + math.sqrt(mean) * normal_number)
    below = mean - candidate
    at_once = candidate + 1.0 > mean - 1.1484  # candidate >= floor(mean - 1.1484), without the floor
    return candidate, at_once | (6.0 * mean * mean * u >= below * below * below)


@njit(cache=True, error_model="numpy")
def _poisson_probability(mean: float, count: float) -> float:
    """Return the Poisson probability of a count; large counts relative to Stirling's formula, so nothing cancels."""
    if count < 10.0:
        return math.exp(count * math.log(mean) - mean) / _FACTORIALS[int(count)]
    r = 1.0 / (count * count)
    stirling = (1 / 12 - r * (1 / 360 - r * (1 / 1260 - r * (1 / 1680 - r / 1188)))) / count
    exponent = count * math.log1p((mean - count) / count) - (mean - count) - stirling
    return math.exp(exponent) / math.sqrt(2.0 * math.pi * count)


@njit(cache=True, error_model="numpy")
def _rounded_normal_probability(mean: float, count: float) -> float:
    """Return the probability that a normal number of the same mean and variance is rounded down to a count."""
    scale = 1.0 / math.sqrt(2.0 * mean)
    near, far = (count - mean) * scale, (count + 1.0 - mean) * scale
    if near < 0.0:
        near, far = -far, -near
    return 0.5 * (math.erfc(near) - math.erfc(far))


@njit(cache=True, error_model="numpy")
def _settled_count(key: Words, pixel: int, mean: float, word: np.uint64) -> float:
    """Return PD's number of a pixel, every step included; f is the rounded normal's probability, p Poisson's."""
    draw = np.uint64(1)
    normal_number, inside = layer_candidate(word, _place(word))
    if not inside:
        normal_number, draw = settled(key, pixel, word, normal_number)
    u = _beginning(word)
    count, accepted = _squeeze(mean, normal_number, u)
    if accepted:
        return count
    rest, _ = drawn(key, pixel, draw)
    draw += np.uint64(1)
    u += unit(rest) * 2.0**-13
    accepted = _squeeze(mean, normal_number, u)[1]
    if accepted:
        return count
    if count >= 0.0:
        f = _rounded_normal_probability(mean, count)
        if f * (1.0 - u) <= _poisson_probability(mean, count):
            return count
    while True:
        first, second = drawn(key, pixel, draw)
        draw += np.uint64(1)
        away, side = -math.log(unit(first)), 2.0 * unit(second) - 1.0
        place = 1.8 + math.copysign(away, side)
        if place > -0.6744:
            count = np.floor(mean + math.sqrt(mean) * place)
            excess = _poisson_probability(mean, count) - _rounded_normal_probability(mean, count)
            if 0.1069 / mean * abs(side) * math.exp(-away) <= excess:
                return count


@njit(cache=True, inline="always", error_model="numpy")
def _exp_minus(x: float) -> float:
    """Return exp(-x) for 0 <= x < 10 to 1e-14, its Taylor series at x/64 squared six times: several at once."""
    y = -x / 64.0
    power = 1.0 + y / 11.0
    for divisor in (10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0):
        power = 1.0 + y / divisor * power
    for _ in range(6):
        power *= power
    return power


@njit(cache=True, error_model="numpy")
def _search(mean: FloatArray, u: FloatArray, p: FloatArray, out: FloatArray) -> None:
    """Write the Poisson quantiles at u over ``out`` where the mean is small, all pixels a count at a time."""
    for i in range(mean.size):
        small = mean[i] < _SMALL_MEAN
        p[i] = _exp_minus(mean[i]) if small else 2.0
        out[i] = 0.0 if small else out[i]
    for count in range(1, _LONGEST_SEARCH):
        inverse = 1.0 / count
        searching = 0
        for i in range(mean.size):
            beyond = u[i] > p[i]
            u[i] = u[i] - p[i] if beyond else u[i]
            p[i] = p[i] * (mean[i] * inverse) if beyond else p[i]
            out[i] = out[i] + 1.0 if beyond else out[i]
            searching += beyond
        if searching == 0:
            break


@njit(cache=True, error_model="numpy")
def _round_normals(  # noqa: PLR0917 - compiled functions take their arrays by position
    key: Words, pixel: int, mean: FloatArray, words: Words, accepted: NDArray[np.bool_], out: FloatArray
) -> None:
    """Fill a chunk with PD's numbers where the mean is large."""
    for i in range(mean.size):
        number, inside = layer_candidate(words[i], _place(words[i]))
        out[i], quick = _squeeze(mean[i], number, _beginning(words[i]))
        accepted[i] = inside & quick
    for i in range(mean.size):
        if not accepted[i] and mean[i] >= _SMALL_MEAN:
            out[i] = _settled_count(key, pixel + i, mean[i], words[i])


@njit(cache=True, error_model="numpy")
def _fill_chunk(  # noqa: PLR0917 - as above
    key: Words,
    pixel: int,
    mean: FloatArray,
    words: Words,
    accepted: NDArray[np.bool_],
    work: FloatArray,
    out: FloatArray,
) -> None:
    """Fill at most a chunk of one row."""
    offset = fill_words(key, pixel, mean.size, words)
    mine = words[offset : offset + mean.size]
    small = 0
    for i in range(mean.size):
        small += mean[i] < _SMALL_MEAN
    if small < mean.size:
        _round_normals(key, pixel, mean, mine, accepted, out)
    if small > 0:
        u, p = work[0, : mean.size], work[1, : mean.size]
        for i in range(mean.size):
            u[i] = unit(mine[i])
        _search(mean, u, p, out)


@njit(nogil=True, cache=True, error_model="numpy")
def fill_poisson(key: Words, first: int, stride: int, mean: FloatArray, out: FloatArray) -> None:
    """Fill a rectangle with Poisson numbers of the given means."""
    rows, columns = mean.shape
    words, accepted, work = np.empty(CHUNK + 2, dtype=np.uint64), np.empty(CHUNK, dtype=np.bool_), np.empty((2, CHUNK))
    for row in range(rows):
        for left in range(0, columns, CHUNK):
            right = min(left + CHUNK, columns)
            pixel = first + row * stride + left
            _fill_chunk(key, pixel, mean[row, left:right], words, accepted, work, out[row, left:right])
