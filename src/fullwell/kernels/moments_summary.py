"""Finished maps become numbers in one sweep, a row of tiles at a time.

For L <= 65536 frames with sum S and sum of squares Q at a pixel, L Q and S^2 are integers below 2^64, so
``D = L Q - S^2`` is exact; ``D / (L (L - 1))`` is the pixel's unbiased variance over frames (METHOD 3.1). Sums run down
each column in a fixed order and are not reassociated: the same maps give the same bits.
`moments_summary_reference` says the same in plain NumPy.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_rows import add_four, add_one
from fullwell.kernels.stack import Band, Stack, rows_of

_WORD = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_BLOCK = 512


Words = NDArray[np.uint32] | NDArray[np.uint64]


class Maps(NamedTuple):
    """Sums over ``frames`` frames, shape (height, width)."""

    codes: NDArray[np.uint32]
    squares: Words
    frames: int


class Surface(NamedTuple):
    """What a band's sums are centred on and projected on.

    Parameters
    ----------
    reference
        Subtracted from the sum over frames, by phase of the row and mosaic column, shape (cell, width) [DN].
    linear, quadratic
        Polynomials of the row within the tile, by phase, shape (cell, rows).

    """

    reference: NDArray[np.float64]
    linear: NDArray[np.float64]
    quadratic: NDArray[np.float64]


class ColumnSums(NamedTuple):
    """Sums down each column of a band, by phase of the row, shape (cell, width).

    Parameters
    ----------
    squares
        Sum of Q.
    low, high
        Sums of the lower and the upper 32 bits of D.
    quartic
        Sum of D^2.
    centred, linear, quadratic
        Sums of S less its reference, times 1 and the two polynomials.
    power
        Sum of its square.

    """

    squares: NDArray[np.uint64]
    low: NDArray[np.uint64]
    high: NDArray[np.uint64]
    quartic: NDArray[np.float64]
    centred: NDArray[np.float64]
    linear: NDArray[np.float64]
    quadratic: NDArray[np.float64]
    power: NDArray[np.float64]


class SpreadCounts(NamedTuple):
    """Counts of D by site in bins of 2^shift, the last of which is open; shape (sites, bins)."""

    bins: NDArray[np.int64]
    shift: int


@njit(cache=True, nogil=True)
def _spread(codes: NDArray[np.uint32], squares: NDArray[np.uint64], frames: int, spread: NDArray[np.uint64]) -> None:
    """Write D of a row of pixels."""
    count = np.uint64(frames)
    for c in range(codes.size):
        spread[c] = count * squares[c] - np.uint64(codes[c]) * np.uint64(codes[c])


@njit(cache=True, nogil=True)
def add_temporal(spread: NDArray[np.uint64], squares: NDArray[np.uint64], phase: int, sums: ColumnSums) -> None:
    """Add a row to the sums that tell of the scatter over frames."""
    # Two sums to a loop: with more, the compiler no longer proves that they do not overlap, and goes one by one.
    totals, low, high, quartic = sums.squares[phase], sums.low[phase], sums.high[phase], sums.quartic[phase]
    for c in range(squares.size):
        totals[c] += squares[c]
        low[c] += spread[c] & _WORD
    for c in range(squares.size):
        high[c] += spread[c] >> _HALF
        value = np.float64(spread[c])
        quartic[c] += value * value


@njit(cache=True, nogil=True)
def add_spatial(codes: NDArray[np.uint32], at: tuple[int, int], surface: Surface, sums: ColumnSums) -> None:
    """Add a row to the sums that tell of the scatter over pixels."""
    phase, plane_row = at
    reference = surface.reference[phase]
    linear, quadratic = surface.linear[phase, plane_row], surface.quadratic[phase, plane_row]
    centred, first, second, power = sums.centred[phase], sums.linear[phase], sums.quadratic[phase], sums.power[phase]
    for c in range(codes.size):
        value = np.float64(codes[c]) - reference[c]
        centred[c] += value
        power[c] += value * value
    for c in range(codes.size):
        value = np.float64(codes[c]) - reference[c]
        first[c] += linear * value
        second[c] += quadratic * value


@njit(cache=True, nogil=True)
def add_four_temporal(
    d: tuple[NDArray[np.uint64], ...], q: tuple[NDArray[np.uint64], ...], phase: int, sums: ColumnSums
) -> None:
    """Add four rows to the sums that tell of the scatter over frames."""
    totals, low, high, quartic = sums.squares[phase], sums.low[phase], sums.high[phase], sums.quartic[phase]
    i, j, k, m = d
    q_i, q_j, q_k, q_m = q
    for c in range(totals.size):
        totals[c] += (q_i[c] + q_j[c]) + (q_k[c] + q_m[c])
    for c in range(totals.size):
        low[c] += (i[c] & _WORD) + (j[c] & _WORD) + (k[c] & _WORD) + (m[c] & _WORD)
        high[c] += (i[c] >> _HALF) + (j[c] >> _HALF) + (k[c] >> _HALF) + (m[c] >> _HALF)
    for c in range(totals.size):
        first, second, third, fourth = np.float64(i[c]), np.float64(j[c]), np.float64(k[c]), np.float64(m[c])
        quartic[c] += (first * first + second * second) + (third * third + fourth * fourth)


@njit(cache=True, nogil=True)
def add_four_spatial(
    s: tuple[NDArray[np.uint32], ...], at: tuple[int, int], surface: Surface, sums: ColumnSums
) -> None:
    """Add four rows, of which the first is ``at`` of its phase, to the sums that tell of the scatter over pixels."""
    phase, row = at
    reference = surface.reference[phase]
    u, v = surface.linear[phase, row : row + 4], surface.quadratic[phase, row : row + 4]
    u_i, u_j, u_k, u_m = u[0], u[1], u[2], u[3]
    v_i, v_j, v_k, v_m = v[0], v[1], v[2], v[3]
    centred, linear, quadratic, power = (
        sums.centred[phase],
        sums.linear[phase],
        sums.quadratic[phase],
        sums.power[phase],
    )
    first, second, third, fourth = s
    for c in range(first.size):
        zero = reference[c]
        i, j = np.float64(first[c]) - zero, np.float64(second[c]) - zero
        k, m = np.float64(third[c]) - zero, np.float64(fourth[c]) - zero
        centred[c] += (i + j) + (k + m)
        power[c] += (i * i + j * j) + (k * k + m * m)
    for c in range(first.size):
        zero = reference[c]
        i, j = np.float64(first[c]) - zero, np.float64(second[c]) - zero
        k, m = np.float64(third[c]) - zero, np.float64(fourth[c]) - zero
        linear[c] += (u_i * i + u_j * j) + (u_k * k + u_m * m)
        quadratic[c] += (v_i * i + v_j * j) + (v_k * k + v_m * m)


@njit(cache=True, nogil=True)
def count_spread(spread: Words, shift: int, even: NDArray[np.int64], odd: NDArray[np.int64]) -> None:
    """Count D of a row of pixels in bins of 2^shift; the last bin takes all that is larger."""
    bits, last = np.uint64(shift), np.uint64(even.size - 1)
    for c in range(spread.size // 2):
        even[min(spread[2 * c] >> bits, last)] += 1
        odd[min(spread[2 * c + 1] >> bits, last)] += 1
    if spread.size % 2:
        even[min(spread[spread.size - 1] >> bits, last)] += 1


@njit(cache=True, nogil=True)
def summarize_band(maps: Maps, band: Band, surface: Surface, sums: ColumnSums, counts: SpreadCounts) -> None:
    """Sum one band of finished maps down its columns, and count D.

    Parameters
    ----------
    maps, band
        What to sum, and which rows.
    surface
        Reference and polynomials.
    sums, counts
        Added to.

    """
    cell, shift = band.cell, counts.shift
    spread = np.empty((4, maps.codes.shape[1]), np.uint64)
    for phase in range(cell):
        top, even, odd = band.top + phase, counts.bins[phase * cell], counts.bins[phase * cell + cell - 1]
        rows = rows_of(band, phase)
        fours = rows - rows % 4
        for row in range(rows):
            at = top + row * cell
            own = spread[row % 4 if row < fours else 0]
            _spread(maps.codes[at], maps.squares[at], maps.frames, own)
            count_spread(own, shift, even, odd)
            if row >= fours:
                add_temporal(own, maps.squares[at], phase, sums)
                add_spatial(maps.codes[at], (phase, row), surface, sums)
            elif row % 4 == 3:
                i, j, k = at - 3 * cell, at - 2 * cell, at - cell
                d = (spread[0], spread[1], spread[2], spread[3])
                q = (maps.squares[i], maps.squares[j], maps.squares[k], maps.squares[at])
                s = (maps.codes[i], maps.codes[j], maps.codes[k], maps.codes[at])
                add_four_temporal(d, q, phase, sums)
                add_four_spatial(s, (phase, row - 3), surface, sums)


@njit(cache=True, nogil=True)
def _pick(spread: Words, bounds: NDArray[np.uint64], picked: NDArray[np.uint64]) -> int:
    """Write every D between bounds one after the other; return how many there are."""
    least, beyond = bounds[0], bounds[1]
    n = 0
    for c in range(spread.size):
        if least <= spread[c] < beyond:
            picked[n] = spread[c]
            n += 1
    return n


@njit(cache=True, nogil=True)
def pick_spreads(maps: Maps, phase: int, bounds: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], NDArray[np.int64]]:
    """Pick every D between bounds from the sites of one phase of the row.

    Parameters
    ----------
    maps
        Finished maps.
    phase
        Of the row within the cell.
    bounds
        Least D of each site, and the one that is beyond, shape (cell, 2).

    Returns
    -------
    :
        D by phase of the column, row-major, and how many there are of each.

    """
    cell = bounds.shape[0]
    height, width = maps.codes.shape
    picked = np.empty((cell, 1024), np.uint64)
    n = np.zeros(cell, np.int64)
    spread = np.empty(width, np.uint64)
    for row in range(phase, height, cell):
        _spread(maps.codes[row], maps.squares[row], maps.frames, spread)
        if n.max() + width > picked.shape[1]:
            grown = np.empty((cell, 2 * picked.shape[1] + width), np.uint64)
            grown[:, : picked.shape[1]] = picked
            picked = grown
        for first in range(cell):
            n[first] += _pick(spread[first::cell], bounds[first], picked[first, n[first] :])
    return picked, n


@njit(cache=True, nogil=True)
def sum_maps(maps: Maps, cell: int) -> tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.uint64]]:
    """Return, by site and mosaic column, the sums of Q and of the lower and upper 32 bits of S^2.

    Parameters
    ----------
    maps
        Finished maps.
    cell
        Period of the mosaic [pixel].

    Returns
    -------
    tuple
        Three arrays of shape (sites, width), zero in the columns of other sites.

    """
    height, width = maps.codes.shape
    by_phase = np.zeros((3, cell, width), np.uint64)
    for row in range(height):
        codes, squares = maps.codes[row], maps.squares[row]
        total, low, high = by_phase[0, row % cell], by_phase[1, row % cell], by_phase[2, row % cell]
        for c in range(width):
            square = np.uint64(codes[c]) * np.uint64(codes[c])
            total[c] += squares[c]
            low[c] += square & _WORD
            high[c] += square >> _HALF
    by_site = np.zeros((3, cell * cell, width), np.uint64)
    for phase in range(cell):
        for column in range(cell):
            by_site[:, phase * cell + column, column::cell] = by_phase[:, phase, column::cell]
    return by_site[0], by_site[1], by_site[2]


@njit(cache=True, nogil=True)
def map_rows(stack: Stack, rows: tuple[int, int], mean: NDArray[np.float32], variance: NDArray[np.float32]) -> None:
    """Write mean and unbiased variance over frames of some rows, from the first to one past the last.

    Rows go by blocks that stay in the nearest cache.

    Parameters
    ----------
    stack
        Frames.
    rows
        First row and one past the last.
    mean, variance
        Shape (height, width), written to [DN, DN^2]; variance is NaN for a single frame.

    """
    width, count = stack.width, stack.starts.size
    share = 1.0 / count
    scale = 1.0 / (count * (count - 1)) if count > 1 else np.nan
    fours = count - count % 4
    whole_codes, whole_squares = np.empty(_BLOCK, np.uint32), np.empty(_BLOCK, np.uint64)
    whole_spread = np.empty(_BLOCK, np.uint64)
    for row in range(rows[0], rows[1]):
        for left in range(0, width, _BLOCK):
            n = min(_BLOCK, width - left)
            codes, squares, spread = whole_codes[:n], whole_squares[:n], whole_spread[:n]
            codes[:] = 0
            squares[:] = 0
            at = stack.starts + (row * width + left)
            for f in range(0, fours, 4):
                x = (
                    stack.codes[at[f] : at[f] + n],
                    stack.codes[at[f + 1] : at[f + 1] + n],
                    stack.codes[at[f + 2] : at[f + 2] + n],
                    stack.codes[at[f + 3] : at[f + 3] + n],
                )
                add_four(x, codes, squares)
            for f in range(fours, count):
                add_one(stack.codes[at[f] : at[f] + n], codes, squares)
            _spread(codes, squares, count, spread)
            mean_block, variance_block = mean[row, left : left + n], variance[row, left : left + n]
            for c in range(n):
                mean_block[c] = np.float32(np.float64(codes[c]) * share)
            for c in range(n):
                variance_block[c] = np.float32(np.float64(spread[c]) * scale)
