"""How many bytes a row takes, from the bytes alone: a picture resembles itself one row further on.

The spectrum of the bytes is whitened before it is turned into an autocorrelation, so that neither the order of bytes
in a word nor the smoothness of a scene counts, but only what repeats: rows stand out as sharp peaks.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_MOST_BYTES: Final = 1 << 21
_PHASES: Final = 12
"""A multiple of the bytes that a cell of words takes, and a group of packed 12-bit samples."""
_CLIP: Final = 4.0
_SHORTEST_ROW: Final = 64
_LONGEST_ROW: Final = 1 << 16
_BANDS: Final = 400
"""The spectrum is flattened over this part of its width: structure shorter than as many samples goes."""
_LINE_LIMIT: Final = 50.0
"""A single frequency counts at most this often the mean around it: words and groups of bytes are such lines."""
_HARMONICS: Final = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class RowPeriod:
    """A number of bytes after which the file resembles itself.

    Parameters
    ----------
    stride
        [byte].
    strength
        How far its multiples stand out on average, in standard deviations of all lags.

    """

    stride: int
    strength: float


def row_periods(stored: NDArray[np.uint8], *, most: int = 6) -> tuple[RowPeriod, ...]:
    """Return the likeliest row periods of a headerless file, the strongest first.

    Parameters
    ----------
    stored
        The file's bytes; the middle 2 MB are looked at.
    most
        How many periods to return at most.

    Returns
    -------
    tuple of RowPeriod
        Rows of a Bayer mosaic resemble the next but one: a period may be two rows, so half of each is there too.

    """
    likeness = _likeness(_middle(stored))
    if likeness.size < 4 * _SHORTEST_ROW:
        return ()
    scale = float(np.std(likeness[_SHORTEST_ROW:])) or 1.0
    likeness = likeness / scale
    lags = np.arange(likeness.size)
    allowed = (lags >= _SHORTEST_ROW) & (lags <= _LONGEST_ROW)
    peaks = [int(lag) for lag in np.argsort(np.where(allowed, likeness, 0.0))[::-1][: 10 * most]]
    named: dict[int, float] = {}
    for lag in peaks:
        for stride in (lag, lag // 2 if lag % 2 == 0 else lag):
            if stride >= _SHORTEST_ROW and stride not in named:
                named[stride] = _comb(likeness, stride)
    ranked = sorted(named.items(), key=lambda one: (-one[1], one[0]))
    return tuple(RowPeriod(stride=stride, strength=strength) for stride, strength in ranked[:most])


def _middle(stored: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the middle of a file, every place in a group of bytes with the same mean and scatter.

    The high byte of a word holds the picture and hardly varies, the low byte varies and holds its noise: both count.
    """
    length = min(stored.size, _MOST_BYTES) // _PHASES * _PHASES
    first = (stored.size - length) // 2
    groups = stored[first : first + length].astype(np.float32).reshape(-1, _PHASES)
    if not length:
        return groups.ravel()
    scatter = groups.std(axis=0)
    groups -= groups.mean(axis=0)
    groups /= np.where(scatter > 0.0, scatter, 1.0)
    return np.clip(groups, -_CLIP, _CLIP).ravel()


def _likeness(samples: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the whitened autocorrelation for lags up to a quarter of the samples, 1 at lag 0."""
    if samples.size < 16 * _SHORTEST_ROW:
        return np.zeros(0)
    size = 1 << (2 * samples.size - 1).bit_length()
    power = np.abs(np.fft.rfft(samples - samples.mean(), size)) ** 2
    around = _running_mean(power, max(power.size // _BANDS, 3))
    white = np.minimum(power / (around + 1e-9 * (float(power.mean()) or 1.0)), _LINE_LIMIT)
    correlation = np.fft.irfft(white)[: samples.size // 4]
    return correlation / (float(correlation[0]) or 1.0)


def _running_mean(values: NDArray[np.floating], width: int) -> NDArray[np.float64]:
    half = width // 2
    total = np.concatenate([[0.0], np.cumsum(np.pad(values.astype(np.float64), half, mode="edge"))])
    return (total[2 * half + 1 :] - total[: -(2 * half + 1)]) / (2 * half + 1)


def _comb(likeness: NDArray[np.float64], stride: int) -> float:
    """Return the mean of a period's multiples; as many as there are, few at most."""
    return float(likeness[stride::stride][:_HARMONICS].mean())
