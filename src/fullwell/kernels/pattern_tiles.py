"""What each tile of a map holds beside a quadratic surface, in one pass over the map.

On a rectangular grid the products of the discrete orthogonal polynomials of degree 0 to 2 along both sides span the
six terms of a quadratic surface and are orthogonal, so that each coefficient is a sum of its own.

Loops that may add in any order become part of the function that calls them: compiled on their own they would add in
another one, and a run that compiles would differ in the last digits from one that finds all compiled.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
MapPlane = NDArray[np.float32 | np.float64]


class Axis(NamedTuple):
    """An axis cut in tiles: where each begins and how long it is; polynomials of degree 1 and 2, tile after tile."""

    starts: NDArray[np.int64]
    lengths: NDArray[np.int64]
    linear: FloatArray
    quadratic: FloatArray


class PatternSums(NamedTuple):
    """Sums over residuals about the surfaces, by tile where nothing else is said.

    Parameters
    ----------
    counts
        On entry, which tiles may count; left to those that are finite and, of relative residuals, have a surface
        above zero everywhere.
    mean
        Of the map; NaN where it holds a value that is not finite.
    power
        Sum of squares.
    inverse
        Sum of surface^-2; 0 where residuals are not relative.
    rows, columns
        Sums of squares of the sums over each row and over each column of the tile.
    by_row
        Sums over each row of the map, shape (V,).
    by_column
        Sums over each column of the map, shape (H,).

    """

    counts: NDArray[np.bool_]
    mean: FloatArray
    power: FloatArray
    inverse: FloatArray
    rows: FloatArray
    columns: FloatArray
    by_row: FloatArray
    by_column: FloatArray


class _Side(NamedTuple):
    """The polynomials of degree 1 and 2 along one side of a tile."""

    linear: FloatArray
    quadratic: FloatArray


Surface = tuple[float, float, float, float, float, float]


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _fitted(tile: MapPlane, down: _Side, across: _Side, values: FloatArray) -> Surface:
    """Copy a tile and return what its surface holds of 1, v, v2, u, u v and u2."""
    v, v2, u, u2 = down.linear, down.quadratic, across.linear, across.quadratic
    one = first = second = left = skew = bent = 0.0
    for r in range(v.size):
        row, kept = tile[r], values[r]
        s0 = s1 = s2 = 0.0
        for c in range(u.size):
            x = np.float64(row[c])
            kept[c] = x
            s0 += x
            s1 += x * u[c]
            s2 += x * u2[c]
        one += s0
        first += s0 * v[r]
        second += s0 * v2[r]
        left += s1
        skew += s1 * v[r]
        bent += s2
    rows, columns = v.size, u.size
    vv, v4, uu, u4 = (v * v).sum(), (v2 * v2).sum(), (u * u).sum(), (u2 * u2).sum()
    return (
        one / (rows * columns),
        first / (vv * columns),
        second / (v4 * columns),
        left / (rows * uu),
        skew / (vv * uu),
        bent / (rows * u4),
    )


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _subtract(values: FloatArray, surface: Surface, down: _Side, across: _Side) -> None:
    """Take the surface off a tile."""
    for r in range(values.shape[0]):
        v, row = down.linear[r], values[r]
        level = surface[0] + surface[1] * v + surface[2] * down.quadratic[r]
        slope, bend = surface[3] + surface[4] * v, surface[5]
        for c in range(row.size):
            row[c] -= level + slope * across.linear[c] + bend * across.quadratic[c]


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _divide(values: FloatArray, surface: Surface, down: _Side, across: _Side) -> tuple[float, bool]:
    """Make a tile its own over the surface, less 1; return the sum of surface^-2, and whether it is above zero."""
    inverse, dark = 0.0, 0
    for r in range(values.shape[0]):
        v, row = down.linear[r], values[r]
        level = surface[0] + surface[1] * v + surface[2] * down.quadratic[r]
        slope, bend = surface[3] + surface[4] * v, surface[5]
        for c in range(row.size):
            height = level + slope * across.linear[c] + bend * across.quadratic[c]
            share = 1.0 / height
            row[c] = (row[c] - height) * share
            inverse += share * share
            dark += height <= 0.0
    return inverse, dark == 0


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _summed(values: FloatArray, by_row: FloatArray, by_column: FloatArray) -> float:
    """Add a tile's rows and columns up, and return its sum of squares."""
    power = 0.0
    by_column[:] = 0.0
    for r in range(values.shape[0]):
        row, total = values[r], 0.0
        for c in range(row.size):
            total += row[c]
            by_column[c] += row[c]
            power += row[c] * row[c]
        by_row[r] = total
    return power


@njit(cache=True, nogil=True, error_model="numpy")
def add_patterns(plane: MapPlane, down: Axis, across: Axis, out: PatternSums, relative: bool) -> None:  # noqa: FBT001 - compiled functions take their arguments by position
    """Take its surface off each tile of a map and sum up what is left.

    Parameters
    ----------
    plane
        The map, shape (V, H), of any strides.
    down, across
        Its axes; tiles have three pixels or more on a side where they may count.
    out
        Filled; sums by row and by column are added to.
    relative
        Whether residuals are divided by the surface.

    """
    work = np.empty((down.lengths.max(), across.lengths.max()))
    rows, columns = np.empty(work.shape[0]), np.empty(work.shape[1])
    for i in range(down.starts.size):
        top, height = down.starts[i], down.lengths[i]
        side = _Side(down.linear[top : top + height], down.quadratic[top : top + height])
        for j in range(across.starts.size):
            left, width = across.starts[j], across.lengths[j]
            along = _Side(across.linear[left : left + width], across.quadratic[left : left + width])
            values, by_row, by_column = work[:height, :width], rows[:height], columns[:width]
            surface = _fitted(plane[top : top + height, left : left + width], side, along, values)
            sound = np.isfinite(surface[0])
            out.mean[i, j] = surface[0] if sound else np.nan
            out.counts[i, j] &= sound
            if not out.counts[i, j]:
                continue
            if relative:
                out.inverse[i, j], out.counts[i, j] = _divide(values, surface, side, along)
                if not out.counts[i, j]:
                    continue
            else:
                _subtract(values, surface, side, along)
            out.power[i, j] = _summed(values, by_row, by_column)
            out.rows[i, j] = (by_row * by_row).sum()
            out.columns[i, j] = (by_column * by_column).sum()
            out.by_row[top : top + height] += by_row
            out.by_column[left : left + width] += by_column
