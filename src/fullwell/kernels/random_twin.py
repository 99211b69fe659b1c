"""The random numbers of `random`, one pixel at a time in plain Python: to read, and to test against."""

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws
from fullwell.kernels.random_normal import ziggurat

Block = tuple[int, int, int, int]


def philox4x32(counter: Block, key: tuple[int, int]) -> Block:
    """Return one block of Philox4x32-10 (Salmon et al., SC11, 2011).

    Parameters
    ----------
    counter, key
        32-bit words, the lowest first.

    Returns
    -------
    tuple of int
        Four 32-bit words.

    Examples
    --------
    >>> [f"{word:08x}" for word in philox4x32((0, 0, 0, 0), (0, 0))]
    ['6627e8d5', 'e169c58d', 'bc57ac4c', '9b00dbd8']

    """
    c0, c1, c2, c3 = counter
    k0, k1 = key
    for _ in range(10):
        low, high = 0xD2511F53 * c0, 0xCD9E8D57 * c2
        c0, c1, c2, c3 = (high >> 32) ^ c1 ^ k0, high & 0xFFFFFFFF, (low >> 32) ^ c3 ^ k1, low & 0xFFFFFFFF
        k0, k1 = (k0 + 0x9E3779B9) & 0xFFFFFFFF, (k1 + 0xBB67AE85) & 0xFFFFFFFF
    return c0, c1, c2, c3


def words(draws: Draws, pixel: int) -> Iterator[int]:
    """Yield the 64-bit words of one pixel: its half of the block it shares, then two of each block of its own."""
    key = (draws.seed & 0xFFFFFFFF, draws.seed >> 32)
    shared = philox4x32((pixel >> 1, 0, draws.frame, draws.stream), key)
    yield shared[2 * (pixel & 1)] << 32 | shared[2 * (pixel & 1) + 1]
    draw = 1
    while True:
        block = philox4x32((pixel, draw, draws.frame, draws.stream), key)
        yield block[0] << 32 | block[1]
        yield block[2] << 32 | block[3]
        draw += 1


def unit(word: int) -> float:
    """Return the upper 52 bits of a word as a number strictly between 0 and 1."""
    return ((word >> 12) + 0.5) * 2.0**-52


def normal_number(mine: Iterator[int], fraction: Callable[[int], float] = unit) -> tuple[float, int]:
    """Return a ziggurat's number and the pixel's first word; ``fraction`` is the place of the first candidate."""
    edges, heights = ziggurat()
    first = word = next(mine)
    place = fraction(word)
    while True:
        layer, sign = word & 0x3FF, -1.0 if word & 0x400 else 1.0
        distance = place * edges[layer]
        if distance < edges[layer + 1]:
            return sign * distance, first
        if layer == 0:
            while True:
                beyond = -math.log(unit(next(mine))) / edges[1]
                if -2.0 * math.log(unit(next(mine))) > beyond * beyond:
                    return sign * (edges[1] + beyond), first
        word, chance = next(mine), unit(next(mine))
        if heights[layer] + chance * (heights[layer + 1] - heights[layer]) < math.exp(-0.5 * distance * distance):
            return sign * distance, first
        place = unit(word)


def poisson_probability(mean: float, count: float) -> float:
    """Return the Poisson probability of a count."""
    return math.exp(count * math.log(mean) - mean - math.lgamma(count + 1.0))


def rounded_normal_probability(mean: float, count: float) -> float:
    """Return the probability that a normal number of the same mean and variance is rounded down to a count."""
    ends = ((count - mean) / math.sqrt(2.0 * mean), (count + 1.0 - mean) / math.sqrt(2.0 * mean))
    near, far = ends if ends[0] >= 0.0 else (-ends[1], -ends[0])
    return 0.5 * (math.erfc(near) - math.erfc(far))


def small_poisson_number(mean: float, u: float) -> float:
    """Return the Poisson quantile at u by sequential search."""
    count, probability = 0, math.exp(-mean)
    while u > probability:
        u -= probability
        count += 1
        probability *= mean * (1.0 / count)
    return float(count)


def large_poisson_number(mean: float, mine: Iterator[int]) -> float:
    """Return a rounded normal number put right (algorithm PD, Ahrens and Dieter 1982), for means of at least 10."""
    number, word = normal_number(mine, lambda word: ((word >> 24) + 0.5) * 2.0**-40)
    rest, _ = next(mine), next(mine)
    u = ((word >> 11 & 0x1FFF) + unit(rest)) * 2.0**-13
    count = math.floor(mean + math.sqrt(mean) * number)
    if count >= math.floor(mean - 1.1484) or 6.0 * mean * mean * u >= (mean - count) ** 3:
        return float(count)
    if count >= 0 and rounded_normal_probability(mean, count) * (1.0 - u) <= poisson_probability(mean, count):
        return float(count)
    while True:
        away, side = -math.log(unit(next(mine))), 2.0 * unit(next(mine)) - 1.0
        place = 1.8 + math.copysign(away, side)
        if place > -0.6744:
            count = math.floor(mean + math.sqrt(mean) * place)
            excess = poisson_probability(mean, count) - rounded_normal_probability(mean, count)
            if 0.1069 / mean * abs(side) * math.exp(-away) <= excess:
                return float(count)


def _pixels(shape: tuple[int, int], draws: Draws) -> Iterator[tuple[tuple[int, int], int]]:
    for row, column in np.ndindex(shape):
        yield (row, column), draws.first + row * draws.stride + column


def normal(shape: tuple[int, int], draws: Draws) -> NDArray[np.float64]:
    """Return what `random.normal` returns."""
    out = np.empty(shape)
    for place, pixel in _pixels(shape, draws):
        out[place] = normal_number(words(draws, pixel))[0]
    return out


def poisson(mean: NDArray[np.float64], draws: Draws) -> NDArray[np.float64]:
    """Return what `random.poisson` returns."""
    out = np.empty(mean.shape)
    for place, pixel in _pixels((mean.shape[0], mean.shape[1]), draws):
        mine = words(draws, pixel)
        small = mean[place] < 10.0
        out[place] = (
            small_poisson_number(mean[place], unit(next(mine))) if small else large_poisson_number(mean[place], mine)
        )
    return out
