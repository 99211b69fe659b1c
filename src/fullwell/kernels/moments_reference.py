"""What `moments` computes, in plain NumPy: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.stack import WIDE, Band, FrameSums, SeriesSums, Stack


def band_of_frames(stack: Stack, band: Band) -> NDArray[np.uint64]:
    """Return the band's rows of every frame, shape (frames, rows, width) [DN]."""
    rows = [(start + band.top * stack.width, start + band.bottom * stack.width) for start in stack.starts]
    pixels = [stack.codes[first:last].reshape(-1, stack.width) for first, last in rows]
    return np.array(pixels, dtype=np.uint64).reshape(len(pixels), band.bottom - band.top, stack.width)


def squares_of(series: SeriesSums) -> NDArray[np.uint64]:
    """Return the sums of squares of every pixel, of whatever width they are kept in."""
    return np.where(series.held[:, np.newaxis] == WIDE, series.wide, series.squares.astype(np.uint64))


def add_band(stack: Stack, band: Band, series: SeriesSums, frames: FrameSums) -> None:
    """Add one band of every frame to the sums of the series, always in 64 bits, and of each frame."""
    x = band_of_frames(stack, band)
    rows = slice(band.top, band.bottom)
    fresh = series.held[rows] == 0
    series.codes[rows][fresh] = 0
    series.wide[rows][fresh] = 0
    series.held[rows] = WIDE
    series.codes[rows] += x.sum(axis=0).astype(np.uint32)
    series.wide[rows] += (x * x).sum(axis=0)
    cell, step = band.cell, band.cell * band.tile
    for phase in range(cell):
        frames.rows[:, rows, phase] += x[:, :, phase::cell].sum(axis=2)
        frames.columns[:, phase, :] += x[:, phase::cell].sum(axis=1)
    tile_row = band.top // step
    for tile in range(-(-stack.width // step)):
        for site in range(cell * cell):
            pixels = x[:, site // cell :: cell, tile * step : (tile + 1) * step][:, :, site % cell :: cell]
            frames.tiles[:, site, tile_row, tile] += pixels.sum(axis=(1, 2))
            if pixels.size:
                _merge_extremes(pixels, series, (site, tile_row, tile))


def _merge_extremes(pixels: NDArray[np.uint64], series: SeriesSums, at: tuple[int, int, int]) -> None:
    """Merge the extreme codes of one tile and how often they occur."""
    lowest = min(int(pixels.min()), int(series.lowest[at]))
    highest = max(int(pixels.max()), int(series.highest[at]))
    kept_low = int(series.n_lowest[at]) if lowest == series.lowest[at] else 0
    kept_high = int(series.n_highest[at]) if highest == series.highest[at] else 0
    series.lowest[at], series.n_lowest[at] = lowest, kept_low + np.count_nonzero(pixels == lowest)
    series.highest[at], series.n_highest[at] = highest, kept_high + np.count_nonzero(pixels == highest)


def count_codes(stack: Stack, band: Band, histogram: NDArray[np.int64]) -> None:
    """Count the codes of one band of every frame; see `moments.count_codes`."""
    x = band_of_frames(stack, band)
    for row in range(2):
        for column in range(2):
            codes = x[:, (row - band.top) % 2 :: 2, column::2].ravel().astype(np.int64)
            histogram[row, column] += np.bincount(codes, minlength=65536)
