"""Spectrograms: the amplitude of fixed pattern against spatial frequency, along rows (EMVA1288 7.6)."""

from typing import Final

import numpy as np

from fullwell.figures.emva1288.sweep import Floats

_BLOCK: Final = 256
"""Rows transformed at a time."""


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
    power = np.zeros(columns // 2 + 1)
    for top in range(0, rows, _BLOCK):
        spectrum = np.fft.rfft(np.subtract(plane[top : top + _BLOCK], mean, order="C"), axis=1)
        power += np.einsum("ij,ij->j", spectrum.real, spectrum.real) + np.einsum(
            "ij,ij->j", spectrum.imag, spectrum.imag
        )
    return power / (rows * columns)


def frequencies(columns: int) -> Floats:
    """Return the frequencies of a spectrum of rows of ``columns`` pixels [cycles/pixel]."""
    return np.arange(columns // 2 + 1) / columns
