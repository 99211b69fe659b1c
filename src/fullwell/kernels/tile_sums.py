"""Sums down the columns of a row of tiles become those of its tiles, for any way to come by them."""

from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import ColumnSums, Maps, SpreadCounts, Surface, summarize_band
from fullwell.kernels.narrow_summary import suits, summarize_narrow
from fullwell.kernels.stack import Band, rows_of

_NARROW_BYTES: Final = 4


class TilePolynomials(NamedTuple):
    """Linear and quadratic polynomial along the axes of tiles.

    Parameters
    ----------
    down
        Of the row within its tile, by band and phase, shape (2, bands, cell, rows).
    across
        Of the mosaic column within its tile, shape (2, width).

    """

    down: NDArray[np.float64]
    across: NDArray[np.float64]


class Tiles(NamedTuple):
    """What is known of tiles before their pixels are looked at.

    Parameters
    ----------
    sums
        Sums of some frames each, shape (anything, sites, tile rows, tile columns), which together are those of S.
    highest
        No code is larger [DN].
    polynomials
        Along their axes.

    """

    sums: NDArray[np.uint64]
    highest: int
    polynomials: TilePolynomials


class TileTotals(NamedTuple):
    """Sums of tiles, by band, site and tile across.

    Parameters
    ----------
    whole
        Of Q and of the lower and the upper 32 bits of D, shape (bands, sites, tiles, 3).
    real
        Of D^2, of the square of S less its reference, and of this times 1, v, u, v2, u v and u2, shape
        (bands, sites, tiles, 8).

    """

    whole: NDArray[np.uint64]
    real: NDArray[np.float64]


@njit(cache=True, nogil=True)
def column_room(cell: int, width: int) -> ColumnSums:
    """Return room for the sums down the columns of a row of tiles."""
    shape = (cell, width)
    return ColumnSums(
        np.zeros(shape, np.uint64),
        np.zeros(shape, np.uint64),
        np.zeros(shape, np.uint64),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
        np.zeros(shape),
    )


@njit(cache=True, nogil=True)
def centre(tiles: NDArray[np.uint64], band: Band, reference: NDArray[np.float64]) -> None:
    """Write the rounded mean of each tile of a band, summed over frames, to its columns.

    Parameters
    ----------
    tiles
        Sums of some frames each, shape (anything, sites, tile rows, tile columns).
    band
        Which tiles.
    reference
        Shape (cell, width), written to.

    """
    cell, step, width = band.cell, band.cell * band.tile, reference.shape[1]
    for phase in range(cell):
        rows = rows_of(band, phase)
        for first in range(cell):
            sums = tiles[:, phase * cell + first, band.top // step]
            for tile in range(-(-width // step)):
                last = min((tile + 1) * step, width)
                n = rows * len(range(tile * step + first, last, cell))
                mean = np.rint(np.float64(sums[:, tile].sum()) / np.float64(n)) if n > 0 else 0.0
                reference[phase, tile * step + first : last : cell] = mean


@njit(cache=True, nogil=True)
def gather(sums: ColumnSums, band: Band, across: NDArray[np.float64], totals: TileTotals) -> None:
    """Add the columns of a band up across each of its tiles.

    Parameters
    ----------
    sums
        Down the columns.
    band
        Which tiles.
    across
        As of `TilePolynomials`.
    totals
        Written to.

    """
    cell, step, width = band.cell, band.cell * band.tile, across.shape[1]
    for phase in range(cell):
        centred, linear, quadratic = sums.centred[phase], sums.linear[phase], sums.quadratic[phase]
        for first in range(cell):
            at = (band.top // step, phase * cell + first)
            for tile in range(totals.whole.shape[2]):
                squares, low, high = np.uint64(0), np.uint64(0), np.uint64(0)
                quartic, power, plain, v, u, v2, u_v, u2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                for c in range(tile * step + first, min((tile + 1) * step, width), cell):
                    squares += sums.squares[phase, c]
                    low += sums.low[phase, c]
                    high += sums.high[phase, c]
                    quartic += sums.quartic[phase, c]
                    power += sums.power[phase, c]
                    plain += centred[c]
                    v += linear[c]
                    u += centred[c] * across[0, c]
                    v2 += quadratic[c]
                    u_v += linear[c] * across[0, c]
                    u2 += centred[c] * across[1, c]
                whole, real = totals.whole[at[0], at[1], tile], totals.real[at[0], at[1], tile]
                whole[0], whole[1], whole[2] = squares, low, high
                real[0], real[1], real[2], real[3] = quartic, power, plain, v
                real[4], real[5], real[6], real[7] = u, v2, u_v, u2


@njit(cache=True, nogil=True)
def sum_tiles(maps: Maps, band: Band, tiles: Tiles, counts: SpreadCounts, totals: TileTotals) -> None:
    """Sum a row of tiles of finished maps, and count D.

    Parameters
    ----------
    maps, band
        What to sum, and which rows.
    tiles
        What is known of them.
    counts
        Added to.
    totals
        Written to.

    """
    cell, width = band.cell, maps.codes.shape[1]
    sums, reference = column_room(cell, width), np.zeros((cell, width))
    centre(tiles.sums, band, reference)
    if maps.squares.itemsize == _NARROW_BYTES and suits(maps.frames, tiles.highest, band):
        summarize_narrow(maps, band, reference, sums, counts)
    else:
        down = tiles.polynomials.down[:, band.top // (cell * band.tile)]
        summarize_band(maps, band, Surface(reference, down[0], down[1]), sums, counts)
    gather(sums, band, tiles.polynomials.across, totals)
