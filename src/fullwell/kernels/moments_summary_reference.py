"""What `moments_summary` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import ColumnSums, Maps, SpreadCounts, Surface
from fullwell.kernels.stack import Band, Stack


def spread_of(maps: Maps) -> NDArray[np.uint64]:
    """Return D = L Q - S^2 of every pixel, shape (height, width)."""
    codes = maps.codes.astype(np.uint64)
    return np.uint64(maps.frames) * maps.squares - codes * codes


def summarize_band(maps: Maps, band: Band, surface: Surface, sums: ColumnSums, counts: SpreadCounts) -> None:
    """Sum one band of finished maps down its columns, and count D; see `moments_summary.summarize_band`."""
    rows, cell, bins = slice(band.top, band.bottom), band.cell, counts.bins.shape[1]
    spread, squares = spread_of(maps)[rows], maps.squares[rows]
    word = np.uint64(0xFFFFFFFF)
    for phase in range(cell):
        d = spread[phase::cell]
        centred = maps.codes[rows][phase::cell].astype(np.float64) - surface.reference[phase]
        linear = surface.linear[phase, : len(centred), np.newaxis]
        quadratic = surface.quadratic[phase, : len(centred), np.newaxis]
        temporal = (squares[phase::cell], d & word, d >> np.uint64(32), d.astype(np.float64) ** 2)
        spatial = (centred, linear * centred, quadratic * centred, centred**2)
        for total, terms in zip(sums, (*temporal, *spatial), strict=True):
            total[phase] += terms.sum(axis=0)
        for column in range(cell):
            at = np.minimum(d[:, column::cell] >> np.uint64(counts.shift), np.uint64(bins - 1))
            counts.bins[phase * cell + column] += np.bincount(at.ravel().astype(np.int64), minlength=bins)


def pick_spreads(maps: Maps, phase: int, bounds: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], NDArray[np.int64]]:
    """Return every D between bounds, by phase of the column; see `moments_summary.pick_spreads`."""
    cell = len(bounds)
    planes = [spread_of(maps)[phase::cell, column::cell].ravel() for column in range(cell)]
    picked = [d[(d >= least) & (d < beyond)] for d, (least, beyond) in zip(planes, bounds, strict=True)]
    n = np.array([d.size for d in picked])
    return np.array([np.pad(d, (0, n.max() - d.size)) for d in picked]), n


def sum_maps(maps: Maps, cell: int) -> tuple[NDArray[np.uint64], NDArray[np.uint64], NDArray[np.uint64]]:
    """Return the sums of Q and of the halves of S^2 by site and column; see `moments_summary.sum_maps`."""
    codes = maps.codes.astype(np.uint64)
    square = codes * codes
    sums = np.zeros((3, cell * cell, codes.shape[1]), np.uint64)
    for site in range(cell * cell):
        row, column = divmod(site, cell)
        for part, values in enumerate((maps.squares, square & np.uint64(0xFFFFFFFF), square >> np.uint64(32))):
            sums[part, site, column::cell] = values[row::cell, column::cell].sum(axis=0)
    return sums[0], sums[1], sums[2]


def map_rows(stack: Stack, rows: tuple[int, int], mean: NDArray[np.float32], variance: NDArray[np.float32]) -> None:
    """Write mean and unbiased variance over frames of some rows; see `moments_summary.map_rows`."""
    part = slice(*rows)
    pixels = [stack.codes[start:][: mean.size].reshape(mean.shape)[part].astype(np.uint64) for start in stack.starts]
    x, count = np.array(pixels), len(pixels)
    total = x.sum(axis=0)
    spread = np.uint64(count) * (x * x).sum(axis=0) - total * total
    mean[part] = total.astype(np.float64) * (1 / count)
    variance[part] = spread.astype(np.float64) * (1 / (count * (count - 1))) if count > 1 else np.nan
