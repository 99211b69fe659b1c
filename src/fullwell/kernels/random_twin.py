"""The random numbers of `random`, one pixel at a time in plain Python: to read, and to test against."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random import Draws, ziggurat

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


def blocks(draws: Draws, pixel: int) -> Iterator[Block]:
    """Yield the blocks of one pixel: draw 0, 1, 2, ..."""
    draw = 0
    while True:
        yield philox4x32((pixel, draw, draws.frame, draws.stream), (draws.seed & 0xFFFFFFFF, draws.seed >> 32))
        draw += 1


def first_unit(block: Block) -> float:
    """Return 52 bits of words 0 and 1 as a number strictly between 0 and 1."""
    return (((block[0] >> 6) << 26 | block[1] >> 6) + 0.5) * 2.0**-52


def last_unit(block: Block) -> float:
    """Return 52 bits of words 2 and 3 likewise."""
    return (((block[2] >> 6) << 26 | block[3] >> 6) + 0.5) * 2.0**-52


def normal_number(mine: Iterator[Block]) -> tuple[float, Block | None]:
    """Return a ziggurat's number; and its block where the number came from the first block's core."""
    edges, heights = ziggurat()
    for attempt, block in enumerate(mine):
        layer, sign = block[2] & 0xFF, -1.0 if block[2] & 0x100 else 1.0
        distance = first_unit(block) * edges[layer]
        if distance < edges[layer + 1]:
            return sign * distance, block if attempt == 0 else None
        if layer == 0:
            for tail in mine:
                beyond = -math.log(first_unit(tail)) / edges[1]
                if -2.0 * math.log(last_unit(tail)) > beyond * beyond:
                    return sign * (edges[1] + beyond), None
        height = heights[layer] + (block[3] + 0.5) * 2.0**-32 * (heights[layer + 1] - heights[layer])
        if height < math.exp(-0.5 * distance * distance):
            return sign * distance, None
    raise AssertionError


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


def large_poisson_number(mean: float, mine: Iterator[Block]) -> float:
    """Return a rounded normal number put right (algorithm PD, Ahrens and Dieter 1982), for means of at least 10."""
    number, block = normal_number(mine)
    u = first_unit(next(mine)) if block is None else ((block[3] << 20 | block[2] >> 12) + 0.5) * 2.0**-52
    count = math.floor(mean + math.sqrt(mean) * number)
    if count >= math.floor(mean - 1.1484) or 6.0 * mean * mean * u >= (mean - count) ** 3:
        return float(count)
    if count >= 0 and rounded_normal_probability(mean, count) * (1.0 - u) <= poisson_probability(mean, count):
        return float(count)
    for further in mine:
        away, side = -math.log(first_unit(further)), 2.0 * last_unit(further) - 1.0
        place = 1.8 + math.copysign(away, side)
        if place > -0.6744:
            count = math.floor(mean + math.sqrt(mean) * place)
            excess = poisson_probability(mean, count) - rounded_normal_probability(mean, count)
            if 0.1069 / mean * abs(side) * math.exp(-away) <= excess:
                return float(count)
    raise AssertionError


def _pixels(shape: tuple[int, int], draws: Draws) -> Iterator[tuple[tuple[int, int], int]]:
    for row, column in np.ndindex(shape):
        yield (row, column), draws.first + row * draws.stride + column


def normal(shape: tuple[int, int], draws: Draws) -> NDArray[np.float64]:
    """Return what `random.normal` returns."""
    out = np.empty(shape)
    for place, pixel in _pixels(shape, draws):
        out[place] = normal_number(blocks(draws, pixel))[0]
    return out


def poisson(mean: NDArray[np.float64], draws: Draws) -> NDArray[np.float64]:
    """Return what `random.poisson` returns."""
    out = np.empty(mean.shape)
    for place, pixel in _pixels((mean.shape[0], mean.shape[1]), draws):
        mine = blocks(draws, pixel)
        small = mean[place] < 10.0
        out[place] = (
            small_poisson_number(mean[place], first_unit(next(mine)))
            if small
            else large_poisson_number(mean[place], mine)
        )
    return out
