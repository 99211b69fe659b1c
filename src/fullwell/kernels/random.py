"""Random numbers by counter: the same seed gives the same bits for any number of workers and any order of tiles.

Every number is a pure function of the seed, a stream, a frame and a pixel. Nothing is shared and nothing is advanced,
so a pixel's numbers do not depend on who asks for them or when. `random_words` makes the bits, `random_normal` and
`random_poisson` the numbers; `random_twin` is the same in plain Python, to read and to test against.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.random_normal import add_scaled_normal, fill_normal
from fullwell.kernels.random_poisson import fill_poisson
from fullwell.kernels.random_words import FloatArray


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
    fill_normal(draws.key(), draws.first, draws.stride, out)
    return out


def add_normal(array: FloatArray, scale: float, draws: Draws) -> None:
    """Add normal numbers of mean 0 and of one standard deviation to an array, in place.

    Parameters
    ----------
    array
        Shape (rows, columns), of any unit; the numbers are those of `normal`.
    scale
        Standard deviation, of the same unit.
    draws
        Which numbers.

    """
    add_scaled_normal(draws.key(), draws.first, draws.stride, scale, array)


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
    fill_poisson(draws.key(), draws.first, draws.stride, np.ascontiguousarray(mean, dtype=np.float64), out)
    return out
