"""Normal numbers from a ziggurat of 1024 layers (Marsaglia and Tsang, J. Stat. Softw. 5, 2000).

A word's lowest 10 bits choose the layer, the next one the sign, its upper bits the place in the layer: separate bits,
as Doornik (2005) asks. Nearly all pixels end in a layer's core; the others draw again.
"""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.random_words import CHUNK, FloatArray, Words, drawn, fill_words, from_one, unit


def ziggurat() -> tuple[FloatArray, FloatArray]:
    """Return the edges of the normal's layers of equal area and the density at them (Marsaglia and Tsang 2000).

    Returns
    -------
    edges, heights
        Shape (1025,) each: ``edges[0]`` is the width of a rectangle of the base layer's area, tail included,
        ``edges[1]`` where the tail begins; heights are exp(-x^2 / 2).

    """
    layers, base = 1024, 4.038849846109505  # with this base the topmost layer has the area of the others
    area = base * math.exp(-0.5 * base * base) + math.sqrt(0.5 * math.pi) * math.erfc(base * math.sqrt(0.5))
    edges = np.zeros(layers + 1)
    edges[0], edges[1] = area / math.exp(-0.5 * base * base), base
    for layer in range(2, layers):
        height = math.exp(-0.5 * edges[layer - 1] ** 2) + area / edges[layer - 1]
        edges[layer] = math.sqrt(-2.0 * math.log(height))
    return edges, np.exp(-0.5 * edges * edges)


_LAYER: Final = np.uint64(0x3FF)
_SIGN: Final = np.uint64(10)
_EDGES, _HEIGHTS = ziggurat()


@njit(cache=True, inline="always", error_model="numpy")
def layer_candidate(word: np.uint64, fraction: float) -> tuple[float, bool]:
    """Return the signed candidate in the layer that a word chooses, and whether it lies in the core."""
    layer = word & _LAYER
    distance = fraction * _EDGES[layer]
    sign = from_one(word >> _SIGN << np.uint64(63))
    return sign * distance, distance < _EDGES[layer + np.uint64(1)]


@njit(cache=True, error_model="numpy")
def _tail(key: Words, pixel: int, draw: np.uint64) -> tuple[float, np.uint64]:
    """Return a distance beyond the ziggurat's base (Marsaglia 1964), and the first draw it left unused."""
    while True:
        first, second = drawn(key, pixel, draw)
        beyond = -math.log(unit(first)) / _EDGES[1]
        draw += np.uint64(1)
        if -2.0 * math.log(unit(second)) > beyond * beyond:
            return _EDGES[1] + beyond, draw


@njit(cache=True, error_model="numpy")
def settled(key: Words, pixel: int, word: np.uint64, x: float) -> tuple[float, np.uint64]:
    """Return the normal number of a pixel whose first candidate x missed the core, and the first draw left unused."""
    draw = np.uint64(1)
    while True:
        layer = word & _LAYER
        if layer == np.uint64(0):
            distance, draw = _tail(key, pixel, draw)
            return math.copysign(distance, x), draw
        following, chance = drawn(key, pixel, draw)
        draw += np.uint64(1)
        below, above = _HEIGHTS[layer], _HEIGHTS[layer + np.uint64(1)]
        if below + unit(chance) * (above - below) < math.exp(-0.5 * x * x):
            return x, draw
        word = following
        x, inside = layer_candidate(word, unit(word))
        if inside:
            return x, draw


@njit(cache=True, error_model="numpy")
def _fill_chunk(key: Words, pixel: int, words: Words, inside: NDArray[np.bool_], out: FloatArray) -> None:
    """Fill at most a chunk of one row."""
    offset = fill_words(key, pixel, out.size, words)
    mine = words[offset : offset + out.size]
    for i in range(out.size):
        out[i], inside[i] = layer_candidate(mine[i], unit(mine[i]))
    for i in range(out.size):
        if not inside[i]:
            out[i], _ = settled(key, pixel + i, mine[i], out[i])


@njit(nogil=True, cache=True, error_model="numpy")
def fill_normal(key: Words, first: int, stride: int, out: FloatArray) -> None:
    """Fill a rectangle with standard normal numbers."""
    rows, columns = out.shape
    words, inside = np.empty(CHUNK + 2, dtype=np.uint64), np.empty(CHUNK, dtype=np.bool_)
    for row in range(rows):
        for left in range(0, columns, CHUNK):
            right = min(left + CHUNK, columns)
            _fill_chunk(key, first + row * stride + left, words, inside, out[row, left:right])


@njit(nogil=True, cache=True, error_model="numpy")
def add_scaled_normal(key: Words, first: int, stride: int, scale: float, out: FloatArray) -> None:
    """Add to a rectangle the multiples of standard normal numbers."""
    rows, columns = out.shape
    words, inside, chunk = np.empty(CHUNK + 2, dtype=np.uint64), np.empty(CHUNK, dtype=np.bool_), np.empty(CHUNK)
    for row in range(rows):
        for left in range(0, columns, CHUNK):
            size = min(CHUNK, columns - left)
            _fill_chunk(key, first + row * stride + left, words, inside, chunk[:size])
            line = out[row, left : left + size]
            for i in range(size):
                line[i] += scale * chunk[i]
