"""Random numbers by counter: the same seed gives the same bits for any number of workers and any order of tiles.

Every number is a pure function of a 64-bit key (the seed) and a 128-bit counter (pixel, draw, frame, stream), mixed by
Philox4x32-10 (Salmon et al., SC11, 2011). Nothing is shared and nothing is advanced, so a pixel's numbers do not depend
on who asks for them or when. Normal numbers come from a ziggurat of 256 layers (Marsaglia and Tsang, J. Stat. Softw. 5,
2000) with separate bits for layer, sign and place. Poisson numbers are exact at every mean: inversion by sequential
search below a mean of 10; above, a rounded normal number put right by acceptance and rejection (Ahrens and Dieter,
algorithm PD, ACM TOMS 8, 1982, made for means of at least 10; here with exact probabilities in place of its series).

`random_twin` is the same in plain Python, to read and to test against.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Words = NDArray[np.uint64]

_MASK: Final = np.uint64(0xFFFFFFFF)
_HALF: Final = np.uint64(32)
_MULTIPLIER_0: Final = np.uint64(0xD2511F53)
_MULTIPLIER_1: Final = np.uint64(0xCD9E8D57)
_WEYL_0: Final = np.uint64(0x9E3779B9)
_WEYL_1: Final = np.uint64(0xBB67AE85)
_SMALL_MEAN: Final = 10.0
_LONGEST_SEARCH: Final = 200
_CHUNK: Final = 256
_FACTORIALS: Final = np.array([math.factorial(k) for k in range(10)], dtype=np.float64)


def ziggurat(layers: int = 256) -> tuple[FloatArray, FloatArray]:
    """Return the edges of the normal's layers of equal area and the density at them (Marsaglia and Tsang 2000).

    Parameters
    ----------
    layers
        Number of layers; the constant ``base`` is that of 256.

    Returns
    -------
    edges, heights
        Shape (layers + 1,) each: ``edges[0]`` is the width of a rectangle of the base layer's area, tail included,
        ``edges[1]`` where the tail begins; heights are exp(-x^2 / 2).

    """
    base = 3.6541528853610088
    area = base * math.exp(-0.5 * base * base) + math.sqrt(0.5 * math.pi) * math.erfc(base * math.sqrt(0.5))
    edges = np.zeros(layers + 1)
    edges[0], edges[1] = area / math.exp(-0.5 * base * base), base
    for layer in range(2, layers):
        height = math.exp(-0.5 * edges[layer - 1] ** 2) + area / edges[layer - 1]
        edges[layer] = math.sqrt(-2.0 * math.log(height))
    return edges, np.exp(-0.5 * edges * edges)


_EDGES, _HEIGHTS = ziggurat()


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Which numbers of the generator: a seed's stream in one frame, for a rectangle of pixels.

    Parameters
    ----------
    seed
        Key of the generator, 0 to 2^64 - 1.
    stream
        One per random process of the sensor, so that adding a process changes no other.
    frame
        Number of the frame in the study.
    first
        Counter of the rectangle's first pixel.
    stride
        Counters from one row of the rectangle to the next.

    """

    seed: int
    stream: int
    frame: int = 0
    first: int = 0
    stride: int = 0

    def key(self) -> NDArray[np.uint64]:
        """Return key, frame and stream as words for the compiled loops, shape (4,)."""
        return np.array([self.seed & 0xFFFFFFFF, self.seed >> 32, self.frame, self.stream], dtype=np.uint64)


@njit(cache=True, inline="always")
def _philox(  # noqa: PLR0917 - compiled functions take their words by position
    c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, k0: np.uint64, k1: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return the four 32-bit words of one block, each in 64 bits."""
    for _ in range(10):
        low = _MULTIPLIER_0 * c0
        high = _MULTIPLIER_1 * c2
        c0 = (high >> _HALF) ^ c1 ^ k0
        c2 = (low >> _HALF) ^ c3 ^ k1
        c1 = high & _MASK
        c3 = low & _MASK
        k0 = (k0 + _WEYL_0) & _MASK
        k1 = (k1 + _WEYL_1) & _MASK
    return c0, c1, c2, c3


@njit(cache=True, inline="always")
def _unit(high: np.uint64, low: np.uint64) -> float:
    """Return a number strictly between 0 and 1 made of 52 bits of two words."""
    return (np.float64(np.int64(((high >> np.uint64(6)) << np.uint64(26)) | (low >> np.uint64(6)))) + 0.5) * 2.0**-52


@njit(cache=True, inline="always")
def _second_unit(middle: np.uint64, low: np.uint64) -> float:
    """Return a number strictly between 0 and 1 of the last word and the bits of the third that the ziggurat leaves."""
    return (np.float64(np.int64((low << np.uint64(20)) | (middle >> np.uint64(12)))) + 0.5) * 2.0**-52


@njit(nogil=True, cache=True, error_model="numpy")
def _fill_uniform(key: Words, first: int, u: FloatArray, v: FloatArray) -> None:
    """Fill one row with two uniform numbers per pixel."""
    k0, k1, c2, c3 = key[0], key[1], key[2], key[3]
    zero = np.uint64(0)
    for i in range(u.size):
        w0, w1, w2, w3 = _philox(np.uint64(first + i), zero, c2, c3, k0, k1)
        u[i] = _unit(w0, w1)
        v[i] = _unit(w2, w3)


@njit(cache=True, inline="always", error_model="numpy")
def _layer_candidate(word: np.uint64, fraction: float) -> tuple[float, bool]:
    """Return the ziggurat's signed candidate in the layer that a word chooses, and whether it lies in the core."""
    layer = word & np.uint64(0xFF)
    distance = fraction * _EDGES[layer]
    sign = 1.0 - 2.0 * np.float64(np.int64((word >> np.uint64(8)) & np.uint64(1)))
    return sign * distance, distance < _EDGES[layer + np.uint64(1)]


@njit(cache=True, error_model="numpy")
def _normal_tail(key: Words, counter: int, draw: np.uint64) -> tuple[float, np.uint64]:
    """Return a normal number beyond the ziggurat's base (Marsaglia 1964), and the first draw it left unused."""
    while True:
        w0, w1, w2, w3 = _philox(np.uint64(counter), draw, key[2], key[3], key[0], key[1])
        beyond = -math.log(_unit(w0, w1)) / _EDGES[1]
        draw += np.uint64(1)
        if -2.0 * math.log(_unit(w2, w3)) > beyond * beyond:
            return _EDGES[1] + beyond, draw


@njit(cache=True, error_model="numpy")
def _normal_anywhere(key: Words, counter: int) -> tuple[float, np.uint64]:
    """Return the ziggurat's number of one pixel, wedges and tail included, and the first draw it left unused."""
    draw = np.uint64(0)
    while True:
        w0, w1, w2, w3 = _philox(np.uint64(counter), draw, key[2], key[3], key[0], key[1])
        x, inside = _layer_candidate(w2, _unit(w0, w1))
        layer = w2 & np.uint64(0xFF)
        draw += np.uint64(1)
        if inside:
            return x, draw
        if layer == np.uint64(0):
            distance, draw = _normal_tail(key, counter, draw)
            return math.copysign(distance, x), draw
        below, above = _HEIGHTS[layer], _HEIGHTS[layer + np.uint64(1)]
        if below + (np.float64(np.int64(w3)) + 0.5) * 2.0**-32 * (above - below) < math.exp(-0.5 * x * x):
            return x, draw


@njit(nogil=True, cache=True, error_model="numpy")
def _fill_normal(key: Words, first: int, stride: int, out: FloatArray) -> None:
    """Fill a rectangle with standard normal numbers."""
    rows, columns = out.shape
    zero = np.uint64(0)
    inside = np.empty(columns, dtype=np.bool_)
    for row in range(rows):
        start = first + row * stride
        line = out[row]
        for i in range(columns):
            w0, w1, w2, _ = _philox(np.uint64(start + i), zero, key[2], key[3], key[0], key[1])
            line[i], inside[i] = _layer_candidate(w2, _unit(w0, w1))
        for i in range(columns):
            if not inside[i]:
                line[i], _ = _normal_anywhere(key, start + i)


@njit(cache=True, inline="always", error_model="numpy")
def _squeeze(mean: float, normal_number: float, u: float) -> tuple[float, bool]:
    """Return PD's candidate, a rounded normal number, and whether its steps I and S accept it at once."""
    candidate = np.floor(mean + math.sqrt(mean) * normal_number)
    below = mean - candidate
    at_once = candidate >= np.floor(mean - 1.1484)
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
def _poisson_anywhere(key: Words, counter: int, mean: float) -> float:
    """Return PD's number of one pixel, every step included; f is the rounded normal's probability, p Poisson's."""
    normal_number, draw = _normal_anywhere(key, counter)
    w0, w1, w2, w3 = _philox(np.uint64(counter), np.uint64(0), key[2], key[3], key[0], key[1])
    u = _second_unit(w2, w3)
    if draw > np.uint64(1) or not _layer_candidate(w2, _unit(w0, w1))[1]:
        w0, w1, _, _ = _philox(np.uint64(counter), draw, key[2], key[3], key[0], key[1])
        u = _unit(w0, w1)
        draw += np.uint64(1)
    count, accepted = _squeeze(mean, normal_number, u)
    if accepted:
        return count
    if count >= 0.0:
        f = _rounded_normal_probability(mean, count)
        if f * (1.0 - u) <= _poisson_probability(mean, count):
            return count
    while True:
        w0, w1, w2, w3 = _philox(np.uint64(counter), draw, key[2], key[3], key[0], key[1])
        draw += np.uint64(1)
        away, side = -math.log(_unit(w0, w1)), 2.0 * _unit(w2, w3) - 1.0
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
def _round_normals(key: Words, counter: int, mean: FloatArray, out: FloatArray) -> None:
    """Fill a chunk with PD's numbers where the mean is large."""
    accepted = np.empty(mean.size, dtype=np.bool_)
    zero = np.uint64(0)
    for i in range(mean.size):
        w0, w1, w2, w3 = _philox(np.uint64(counter + i), zero, key[2], key[3], key[0], key[1])
        number, inside = _layer_candidate(w2, _unit(w0, w1))
        out[i], quick = _squeeze(mean[i], number, _second_unit(w2, w3))
        accepted[i] = inside & quick
    for i in range(mean.size):
        if not accepted[i] and mean[i] >= _SMALL_MEAN:
            out[i] = _poisson_anywhere(key, counter + i, mean[i])


@njit(cache=True, error_model="numpy")
def _fill_poisson_chunk(key: Words, counter: int, mean: FloatArray, work: FloatArray, out: FloatArray) -> None:
    """Fill at most a chunk of one row with Poisson numbers."""
    lowest, highest = math.inf, 0.0
    for i in range(mean.size):
        lowest, highest = min(lowest, mean[i]), max(highest, mean[i])
    if highest >= _SMALL_MEAN:
        _round_normals(key, counter, mean, out)
    if lowest < _SMALL_MEAN:
        u, v = work[0, : mean.size], work[1, : mean.size]
        _fill_uniform(key, counter, u, v)
        _search(mean, u, v, out)


@njit(nogil=True, cache=True, error_model="numpy")
def _fill_poisson(key: Words, first: int, stride: int, mean: FloatArray, out: FloatArray) -> None:
    """Fill a rectangle with Poisson numbers of the given means."""
    rows, columns = mean.shape
    work = np.empty((2, _CHUNK))
    for row in range(rows):
        for left in range(0, columns, _CHUNK):
            right = min(left + _CHUNK, columns)
            counter = first + row * stride + left
            _fill_poisson_chunk(key, counter, mean[row, left:right], work, out[row, left:right])


def normal(shape: tuple[int, int], draws: Draws) -> FloatArray:
    """Return normal numbers of mean 0 and variance 1.

    Parameters
    ----------
    shape
        Rows and columns of the rectangle.
    draws
        Which numbers.

    Returns
    -------
    ndarray
        ``shape``, float64.

    """
    out = np.empty(shape)
    _fill_normal(draws.key(), draws.first, draws.stride, out)
    return out


def poisson(mean: FloatArray, draws: Draws) -> FloatArray:
    """Return Poisson numbers, exact at every mean.

    Parameters
    ----------
    mean
        Means, shape (rows, columns), zero or more.
    draws
        Which numbers.

    Returns
    -------
    ndarray
        Counts, the shape of ``mean``, float64.

    """
    out = np.empty(mean.shape)
    _fill_poisson(draws.key(), draws.first, draws.stride, np.ascontiguousarray(mean, dtype=np.float64), out)
    return out
