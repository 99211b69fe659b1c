"""What `pixel_maps` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.pixel_maps import Rows


def _by_pixel(coefficients: NDArray[np.float64], top: int, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Repeat coefficients of shape (totals, cell, cell) over the pixels of some rows."""
    cell = coefficients.shape[-1]
    rows, columns = (top + np.arange(shape[0])) % cell, np.arange(shape[1]) % cell
    return coefficients[:, rows[:, np.newaxis], columns]


def add_one(rows: Rows, top: int, coefficients: NDArray[np.float64], totals: NDArray[np.float64]) -> None:
    """Add a multiple of one map to each total; see `pixel_maps.add_one`."""
    totals[:, : rows.shape[0]] += _by_pixel(coefficients, top, rows.shape) * rows.astype(np.float64)


def add_four(
    four: tuple[Rows, Rows, Rows, Rows], top: int, coefficients: NDArray[np.float64], totals: NDArray[np.float64]
) -> None:
    """Add multiples of four maps to each total; see `pixel_maps.add_four`."""
    parts = [_by_pixel(coefficients[:, k], top, rows.shape) * rows.astype(np.float64) for k, rows in enumerate(four)]
    totals[:, : four[0].shape[0]] += parts[0] + parts[1] + parts[2] + parts[3]
