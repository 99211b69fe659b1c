"""Tiles come to the same bits whichever loop sums them up, up to the largest sums that narrow loops hold."""

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.kernels.moments_summary import Maps, SpreadCounts, Surface, summarize_band
from fullwell.kernels.narrow_summary import suits, summarize_narrow
from fullwell.kernels.stack import Band
from fullwell.kernels.tile_sums import TileTotals, centre, column_room, gather
from fullwell.statistics.moments import Layout
from fullwell.statistics.tiles import tile_polynomials


def largest_code(frames: int, bands: Sequence[Band]) -> int:
    """Return the largest code that narrow loops hold in some rows of tiles."""
    beyond = bisect_left(range(65536), 1, key=lambda code: 1 - all(suits(frames, code, band) for band in bands))
    return beyond - 1


@given(
    frames=st.integers(1, 12),
    height=st.integers(2, 150),
    width=st.sampled_from((2, 33, 511, 512, 515, 1030)),
    cfa=st.sampled_from(("mono", "RGGB")),
    share=st.sampled_from((0.01, 0.6, 1.0)),
    shift=st.integers(0, 20),
    seed=st.integers(0, 2**32 - 1),
)
def test_narrow_loops_come_to_the_bits_of_wide_ones(
    *, frames: int, height: int, width: int, cfa: str, share: float, shift: int, seed: int
) -> None:
    """Most codes are the largest one or 0, so that D comes as close to its limit as it can."""
    layout = Layout(height=height, width=width, cfa=cfa)
    rng = np.random.default_rng(seed)
    highest = int(share * max(0, largest_code(frames, layout.bands())))
    x = highest * rng.integers(0, 2, (frames, height, width), dtype=np.uint64)
    x -= np.minimum(x, rng.integers(0, 3, x.shape, dtype=np.uint64))
    maps = Maps(x.sum(axis=0).astype(np.uint32), (x * x).sum(axis=0).astype(np.uint32), frames)
    down = tile_polynomials(layout).down
    for index, band in enumerate(layout.bands()):
        if not suits(frames, highest, band):
            continue
        reference = rng.integers(0, frames * highest + 1, (layout.cell, width)).astype(np.float64)
        narrow, wide = column_room(layout.cell, width), column_room(layout.cell, width)
        narrow_counts, wide_counts = np.zeros((2, layout.sites, 64), np.int64)
        summarize_narrow(maps, band, reference, narrow, SpreadCounts(narrow_counts, shift))
        surface = Surface(reference, down[0, index], down[1, index])
        summarize_band(maps, band, surface, wide, SpreadCounts(wide_counts, shift))
        np.testing.assert_array_equal(narrow_counts, wide_counts)
        for mine, its in zip(narrow, wide, strict=True):
            np.testing.assert_array_equal(mine, its)


@pytest.mark.parametrize("rows", [1, 2, 64, 128, 256])
@pytest.mark.parametrize("frames", [1, 5, 90])
def test_narrow_loops_are_given_what_they_hold(frames: int, rows: int) -> None:
    band = Band(0, rows, 1, 256)
    code = largest_code(frames, [band])
    total, triangles = frames * code, sum(m * (m + 1) // 2 for m in range(1, rows + 1))
    assert total * triangles < 2**32
    assert total**2 // 4 < 2**31  # D
    assert total * code < 2**32  # Q
    assert code == 65535 or total + frames > 92681 or (total + frames) * triangles >= 2**32


def test_rows_whose_polynomials_are_not_exact_are_left_to_other_loops() -> None:
    assert not suits(5, 10, Band(0, 48, 1, 64))
    assert not suits(5, 10, Band(0, 96, 2, 64))
    assert suits(5, 10, Band(0, 94, 2, 64))


@given(
    height=st.integers(2, 40),
    width=st.integers(2, 40),
    cfa=st.sampled_from(("mono", "RGGB")),
    tile=st.integers(1, 9),
    seed=st.integers(0, 2**32 - 1),
)
def test_columns_are_gathered_into_tiles(*, height: int, width: int, cfa: str, tile: int, seed: int) -> None:
    layout = Layout(height=height, width=width, cfa=cfa, tile=tile)
    cell, (rows, columns) = layout.cell, layout.tiles
    rng = np.random.default_rng(seed)
    totals = TileTotals(
        np.zeros((rows, layout.sites, columns, 3), np.uint64), np.zeros((rows, layout.sites, columns, 8))
    )
    across = rng.integers(-9, 10, (2, width)).astype(np.float64)
    for index, band in enumerate(layout.bands()):
        sums = column_room(cell, width)
        for part in sums:
            part[...] = rng.integers(0, 1000, part.shape)
        gather(sums, band, across, totals)
        u, u2 = across
        for site in range(layout.sites):
            phase, first = divmod(site, cell)
            whole = sums.squares, sums.low, sums.high
            plain, linear = sums.centred, sums.linear
            real = sums.quartic, sums.power, plain, linear, plain * u, sums.quadratic, linear * u, plain * u2
            for at in range(-(-layout.plane(site)[1] // tile)):
                own = np.s_[phase, at * tile * cell + first : (at + 1) * tile * cell : cell]
                assert totals.whole[index, site, at].tolist() == [int(part[own].sum()) for part in whole]
                assert totals.real[index, site, at].tolist() == [float(part[own].sum()) for part in real]


def test_tiles_are_centred_on_their_rounded_mean() -> None:
    layout = Layout(height=6, width=10, cfa="RGGB", tile=2)
    x = np.random.default_rng(5).integers(0, 1000, (3, 6, 10)).astype(np.uint64)
    sums = np.zeros((3, 4, *layout.tiles), np.uint64)
    for (site, row, column), _ in np.ndenumerate(sums[0]):
        phase, first = divmod(site, 2)
        part = x[:, 4 * row + phase : 4 * row + 4 : 2, 4 * column + first : 4 * column + 4 : 2]
        sums[:, site, row, column] = part.sum(axis=(1, 2))
    for band in layout.bands():
        reference = np.zeros((2, 10))
        centre(sums, band, reference)
        for column in range(10):
            for phase in range(2):
                left = column // 4 * 4 + column % 2
                part = x[:, band.top + phase : band.bottom : 2, left : column // 4 * 4 + 4 : 2].sum(axis=0)
                assert reference[phase, column] == np.rint(part.mean())
