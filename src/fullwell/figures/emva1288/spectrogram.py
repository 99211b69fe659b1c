"""Spectrograms: the amplitude of fixed pattern against spatial frequency, along rows (EMVA1288 7.6)."""

from typing import Final

import numpy as np

from fullwell.figures.emva1288.sweep import Floats

_BLOCK: Final = 32
"""Rows transformed at a time, so that they stay in the cache."""


def power_spectrum(plane: Floats) -> Floats:
    """Return the mean power of the rows of a plane at 0 to N/2 cycles per row.

    Parameters
    ----------
    plane
        Shape (M, N), in any order in memory; its mean is subtracted [DN].

    Returns
    -------
    ndarray
        Shape (N // 2 + 1,); white noise has the power of its variance [DN^2].

    Examples
    --------
    >>> row = 2 * np.cos(2 * np.pi * 3 * np.arange(16) / 16)
    >>> float(power_spectrum(row[np.newaxis])[3].round(9))
    16.0

    """
    rows, columns = plane.shape
    mean = plane.mean()
    squares = np.zeros(2 * (columns // 2 + 1))
    for top in range(0, rows, _BLOCK):
        block = np.ascontiguousarray(plane[top : top + _BLOCK] - mean)
        parts = np.fft.rfft(block, axis=1).view(np.float64)
        squares += np.einsum("ij,ij->j", parts, parts)
    return squares.reshape(-1, 2).sum(axis=1) / (rows * columns)


def frequencies(columns: int) -> Floats:
    """Return the frequencies of a spectrum of rows of ``columns`` pixels [cycles/pixel]."""
    return np.arange(columns // 2 + 1) / columns
