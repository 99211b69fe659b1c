"""The rows of a PNG file become pixels: each was stored as differences from its neighbours (PNG, chapter 9).

`undo_filters` is compiled; `undo_filters_plain` is its readable twin.
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

_NONE: Final = 0
_SUB: Final = 1
_UP: Final = 2
_AVERAGE: Final = 3
_PAETH: Final = 4


@njit(cache=True, nogil=True)
def _paeth(left: np.int64, above: np.int64, corner: np.int64) -> np.int64:
    """Return which of three neighbours lies nearest to left + above - corner."""
    to_left, to_above = abs(above - corner), abs(left - corner)
    to_corner = abs(left + above - 2 * corner)
    if to_left <= to_above and to_left <= to_corner:
        return left
    return above if to_above <= to_corner else corner


@njit(cache=True, nogil=True)
def _add_up(x: NDArray[np.uint8], size: int) -> None:
    """Add to each byte of a row that of the pixel before; both bytes of a pixel side by side."""
    first, second = np.uint8(0), np.uint8(0)
    if size == 1:
        for c in range(x.size):
            first = np.uint8(first + x[c])
            x[c] = first
        return
    for c in range(x.size // 2):
        first, second = np.uint8(first + x[2 * c]), np.uint8(second + x[2 * c + 1])
        x[2 * c], x[2 * c + 1] = first, second


@njit(cache=True, nogil=True)
def _undo_row(kind: np.uint8, x: NDArray[np.uint8], above: NDArray[np.uint8], size: int) -> None:
    """Undo the filter of a row in place; ``size`` is that of a pixel [byte]."""
    if kind == _UP:
        for c in range(x.size):
            x[c] = np.uint8(x[c] + above[c])
    elif kind == _SUB:
        _add_up(x, size)
    elif kind == _AVERAGE:
        for c in range(x.size):
            left = np.int64(x[c - size]) if c >= size else np.int64(0)
            x[c] = np.uint8(x[c] + (left + np.int64(above[c])) // 2)
    elif kind == _PAETH:
        for c in range(x.size):
            left = np.int64(x[c - size]) if c >= size else np.int64(0)
            corner = np.int64(above[c - size]) if c >= size else np.int64(0)
            x[c] = np.uint8(x[c] + _paeth(left, np.int64(above[c]), corner))


@njit(cache=True, nogil=True)
def undo_filters(lines: NDArray[np.uint8], out: NDArray[np.uint16], size: int) -> bool:
    """Undo the filter of each row.

    Parameters
    ----------
    lines
        Number of the filter, then the bytes of the row, shape (rows, 1 + size * columns); changed in place.
    out
        Pixels, shape (rows, columns), written to [DN].
    size
        Bytes of a pixel: 1, or 2 with the higher first.

    Returns
    -------
    bool
        Whether all filters are known; ``out`` is not whole where one is not.

    """
    above = np.zeros(lines.shape[1] - 1, np.uint8)
    for row in range(lines.shape[0]):
        kind, x, target = lines[row, 0], lines[row, 1:], out[row]
        if kind > _PAETH:
            return False
        _undo_row(kind, x, above, size)
        if size == 1:
            for c in range(target.size):
                target[c] = x[c]
        else:
            for c in range(target.size):
                target[c] = np.uint16((np.uint16(x[2 * c]) << np.uint16(8)) | np.uint16(x[2 * c + 1]))
        above = x
    return True


def undo_filters_plain(lines: NDArray[np.uint8], out: NDArray[np.uint16], size: int) -> bool:
    """Do what `undo_filters` does, pixel by pixel."""
    above = np.zeros(lines.shape[1] - 1, np.uint8)
    for row, (kind, *stored) in enumerate(lines.tolist()):
        x: list[int] = []
        for c, value in enumerate(stored):
            left, corner = (x[c - size], int(above[c - size])) if c >= size else (0, 0)
            up = int(above[c])
            nearest = min((left, up, corner), key=lambda one: abs(left + up - corner - one))
            predictions = {_NONE: 0, _SUB: left, _UP: up, _AVERAGE: (left + up) // 2, _PAETH: nearest}
            if kind not in predictions:
                return False
            x.append((value + predictions[kind]) % 256)
        above = np.array(x, np.uint8)
        out[row] = above if size == 1 else above.view(">u2")
    return True
