"""Moments of a series: exact integers that merge in any order, in memory that does not grow with the frames.

Raw codes are integers, so their sums and sums of squares are integers too, and adding integers is exact and
associative: frames may arrive in any order, on any number of threads, and halves computed apart may be merged; the bits
are the same. `finalize` turns moments into `SeriesStatistics`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments import add_band, count_codes
from fullwell.kernels.moments_summary import Maps
from fullwell.kernels.stack import Band, FrameSums, Stack
from fullwell.raw.cfa import cell as cell_of
from fullwell.statistics.batch import Batch
from fullwell.statistics.exact import sum_of_squares
from fullwell.statistics.pixel_sums import empty_maps, finished_maps, merge_maps, packed_maps, unpacked_maps

MOST_FRAMES: Final = 65536
LARGEST_SIDE: Final = 65536
LARGEST_TILE: Final = 256
CODES: Final = 65536
_STRIP_BYTES: Final = 1 << 18
_STRIP_ROWS: Final = 8
"""Of each phase, at least: with fewer, what is done once a strip outweighs what is done with its pixels."""
_WORD = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """How a mosaic is divided.

    Parameters
    ----------
    height, width
        Size of the mosaic [pixel].
    cfa
        Order at the top-left pixel.
    tile
        Edge of a tile [pixel of a plane].

    """

    height: int
    width: int
    cfa: str
    tile: int = 64

    def __post_init__(self) -> None:
        """Refuse what the sums cannot hold."""
        if not all(self.cell <= side <= LARGEST_SIDE for side in (self.height, self.width)):
            raise ValueError(
                f"a mosaic has {self.cell} to {LARGEST_SIDE} rows and columns, not {self.height} x {self.width}"
            )
        if not 1 <= self.tile <= LARGEST_TILE:
            raise ValueError(f"a tile has an edge of 1 to {LARGEST_TILE} pixels, not {self.tile}")

    @property
    def cell(self) -> int:
        """Return the period of the mosaic [pixel]."""
        return cell_of(self.cfa)

    @property
    def sites(self) -> int:
        """Return the number of planes."""
        return self.cell**2

    @property
    def tiles(self) -> tuple[int, int]:
        """Return the rows and columns of tiles of the largest plane."""
        return -(-self.height // self._step), -(-self.width // self._step)

    def plane(self, site: int) -> tuple[int, int]:
        """Return the rows and columns of a plane [pixel]."""
        row, column = divmod(site, self.cell)
        return -((row - self.height) // self.cell), -((column - self.width) // self.cell)

    def bands(self) -> tuple[Band, ...]:
        """Return the rows of tiles, top to bottom."""
        return self._cut(self._step)

    def strips(self) -> tuple[Band, ...]:
        """Return the rows of tiles cut into strips, top to bottom: many frames of a strip stay in the cache."""
        rows = self.strip_rows
        return tuple(
            Band(top, min(top + rows, band.bottom), band.cell, band.tile)
            for band in self.bands()
            for top in range(band.top, band.bottom, rows)
        )

    def parts(self) -> tuple[Band, ...]:
        """Return rows of tiles, several together where they are short, top to bottom: few frames stay in the cache."""
        return self._cut(self.part_rows)

    @property
    def strip_rows(self) -> int:
        """Return the rows of the largest strip."""
        return min(self._rows_of(_STRIP_ROWS * self.cell), self._step, self.height)

    @property
    def part_rows(self) -> int:
        """Return the rows of the largest part."""
        return min(self._rows_of(self._step), self.height)

    @property
    def strip_bytes(self) -> int:
        """Return the bytes of a strip of a frame, at most [byte]."""
        return 2 * self.width * self.strip_rows

    @property
    def _step(self) -> int:
        """Return the rows of a row of tiles."""
        return self.cell * self.tile

    def _rows_of(self, least: int) -> int:
        """Return as many times so many rows as stay in the cache, at least once."""
        return max(least, _STRIP_BYTES // (2 * self.width) // least * least)

    def _cut(self, rows: int) -> tuple[Band, ...]:
        cell, tile, height = self.cell, self.tile, self.height
        return tuple(Band(top, min(top + rows, height), cell, tile) for top in range(0, height, rows))


def by_site(counts: NDArray[np.int64], *, cell: int) -> NDArray[np.int64]:
    """Return counts by phase in a cell of two, shape (2, 2, n), as counts by site, shape (sites, n)."""
    return counts.reshape(4, -1) if cell == 2 else counts.sum(axis=(0, 1))[np.newaxis]


def stack_of(mosaics: Sequence[NDArray[np.uint16]]) -> Stack:
    """Copy mosaics of one size into a block of memory."""
    block = np.stack(mosaics).astype(np.uint16, copy=False)
    frames, height, width = block.shape
    codes = block.reshape(-1)
    codes.flags.writeable = False
    return Stack(codes, np.arange(frames, dtype=np.int64) * (height * width), width)


class Moments:
    """Exact sums over the frames of a series; the maps hold nothing before there is a frame.

    Frames may be added from several threads at once; other methods expect that nobody adds.

    Parameters
    ----------
    layout
        Size of the mosaic, its planes and tiles.
    every_histogram
        Whether the codes of every frame are counted (dark and bias series), or those of the first by name.

    """

    def __init__(self, layout: Layout, *, every_histogram: bool = False) -> None:
        self.layout = layout
        grid = (layout.sites, *layout.tiles)
        self.maps = empty_maps((layout.height, layout.width), grid)
        self.row_sums = np.zeros((layout.height, layout.cell), np.uint64)
        self.column_sums = np.zeros((layout.cell, layout.width), np.uint64)
        self.tile_sums = np.zeros(grid, np.uint64)
        self.tile_squares = np.zeros((2, *grid), np.uint64)
        self.histogram = np.zeros((layout.sites, CODES), np.int64)
        self._strips = layout.strips()
        self._places = {strip.top: at for at, strip in enumerate(self._strips)}
        self._make_locks()
        self.clear(every_histogram=every_histogram)

    def _make_locks(self) -> None:
        self._strip_locks = tuple(Lock() for _ in self._strips)
        self._lock = Lock()

    def __getstate__(self) -> dict[str, object]:
        """Return what goes to another process: everything but the locks, and maps that hold nothing."""
        state: dict[str, object] = dict(vars(self))
        del state["_strip_locks"], state["_lock"]
        return state | {"maps": packed_maps(self.maps)}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Take what came from another process."""
        vars(self).update(state)
        self.maps = unpacked_maps(self.maps)
        self._make_locks()

    def clear(self, *, every_histogram: bool) -> None:
        """Forget all frames; the maps are written anew by the first frames to come."""
        self.every_histogram = every_histogram
        self.maps.lowest[...] = CODES - 1
        for part in (
            self.maps.held,
            self.maps.highest,
            self.maps.n_lowest,
            self.maps.n_highest,
            self.row_sums,
            self.column_sums,
            self.tile_sums,
            self.tile_squares,
            self.histogram,
        ):
            part[...] = 0
        self.frame_sums: dict[str, tuple[int, ...]] = {}
        self.row_squares = [0] * self.layout.sites
        self.column_squares = [0] * self.layout.sites
        self.histogram_frames: tuple[str, ...] = ()
        self._first_counted: str | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the frames, sorted."""
        return tuple(sorted(self.frame_sums))

    def add(self, names: Sequence[str], stack: Stack) -> None:
        """Add frames.

        Parameters
        ----------
        names
            One per frame.
        stack
            The frames.

        Raises
        ------
        ValueError
            If a name is there already, or frames or their size are beyond what the sums hold.

        """
        most = max(1, (CODES - 1) // self.layout.tile)
        for start in range(0, len(names), most):
            part = Stack(stack.codes, stack.starts[start : start + most], stack.width)
            addition = self.begin(Batch(names[start : start + most], part))
            for strip in self._strips:
                addition.add(part, strip)
            addition.commit()

    def begin(self, batch: Batch) -> "MomentsAddition":
        """Return what takes the rows of a batch; may be called from several threads at once.

        Raises
        ------
        ValueError
            If a name is there already, or there are too many frames.

        """
        with self._lock:
            self._refuse_names(batch.names)
            counted = batch.names if self.every_histogram else self._claimed(min(batch.names))
        return MomentsAddition(self, batch.names, counted=counted)

    def add_rows(self, stack: Stack, band: Band, frames: FrameSums) -> None:
        """Add a strip to the maps and extremes, and to the sums of each frame, which are the caller's."""
        at = self._places[band.top]
        with self._strip_locks[at]:
            add_band(stack, band, self.maps, frames)

    def commit(
        self, names: Sequence[str], frames: FrameSums, *, counted: tuple[str, ...], histogram: NDArray[np.int64]
    ) -> None:
        """Add the sums of each frame once all its rows are added; ``counted`` are the frames of ``histogram``."""
        with self._lock:
            self._commit(names, frames)
            if counted:
                self._commit_histogram(counted, histogram)

    def merge(self, other: "Moments") -> None:
        """Add the frames of other moments of the same layout; ``other`` is left as it is.

        Raises
        ------
        ValueError
            If the layouts differ or a frame is in both.

        """
        if other.layout != self.layout or other.every_histogram != self.every_histogram:
            raise ValueError("moments of different layouts cannot be merged")
        self._refuse_names(other.names)
        if not other.names:
            return
        merge_maps(self.maps, other.maps, fresh=not self.names)
        self.frame_sums.update(other.frame_sums)
        self.row_sums += other.row_sums
        self.column_sums += other.column_sums
        self.tile_sums += other.tile_sums
        self.tile_squares += other.tile_squares
        for site in range(self.layout.sites):
            self.row_squares[site] += other.row_squares[site]
            self.column_squares[site] += other.column_squares[site]
        if other.histogram_frames:
            self._commit_histogram(other.histogram_frames, other.histogram)

    def finished(self) -> Maps:
        """Return the sums of single pixels, all squares of one width."""
        return finished_maps(self.maps, len(self.frame_sums))

    def _claimed(self, name: str) -> tuple[str, ...]:
        """Return a frame whose codes are to be counted, unless those of an earlier one by name are already."""
        if self._first_counted is not None and self._first_counted < name:
            return ()
        self._first_counted = name
        return (name,)

    def _refuse_names(self, names: Sequence[str]) -> None:
        if len(set(names)) != len(names) or any(name in self.frame_sums for name in names):
            raise ValueError("a frame was given twice")
        if len(self.frame_sums) + len(names) > MOST_FRAMES:
            raise ValueError(f"a series holds at most {MOST_FRAMES} frames")

    def _commit(self, names: Sequence[str], frames: FrameSums) -> None:
        """Add the margins of some frames."""
        cell = self.layout.cell
        totals = frames.tiles.sum(axis=(2, 3), dtype=np.uint64)
        for name, total in zip(names, totals.tolist(), strict=True):
            self.frame_sums[name] = tuple(total)
        self.row_sums += frames.rows.sum(axis=0, dtype=np.uint64)
        self.column_sums += frames.columns.sum(axis=0, dtype=np.uint64)
        self.tile_sums += frames.tiles.sum(axis=0, dtype=np.uint64)
        squares = frames.tiles * frames.tiles
        self.tile_squares[0] += (squares & _WORD).sum(axis=0, dtype=np.uint64)
        self.tile_squares[1] += (squares >> _HALF).sum(axis=0, dtype=np.uint64)
        for site in range(self.layout.sites):
            row, column = divmod(site, cell)
            self.row_squares[site] += sum_of_squares(frames.rows[:, row::cell, column])
            self.column_squares[site] += sum_of_squares(frames.columns[:, row, column::cell])

    def _commit_histogram(self, names: tuple[str, ...], histogram: NDArray[np.int64]) -> None:
        """Add the counts of every frame, or keep those of the first by name."""
        if self.every_histogram:
            self.histogram += histogram
            self.histogram_frames = tuple(sorted((*self.histogram_frames, *names)))
        elif not self.histogram_frames or names[0] < self.histogram_frames[0]:
            self.histogram[...] = histogram
            self.histogram_frames = names


class MomentsAddition:
    """A batch on its way into moments, in the hands of one thread.

    Parameters
    ----------
    moments
        Where it goes.
    names
        Of its frames.
    counted
        Those whose codes are counted.

    Attributes
    ----------
    frames
        Sums over the pixels of each frame.
    places
        Which frames' codes are counted, shape (counted,).
    histogram
        The counts, by phase of the row and of the column in a cell of two, shape (2, 2, 65536).

    """

    def __init__(self, moments: Moments, names: tuple[str, ...], *, counted: tuple[str, ...]) -> None:
        layout, frames = moments.layout, len(names)
        self._moments = moments
        self._names = names
        self._counted = counted
        self.places = np.array([names.index(name) for name in counted], np.int64)
        self.frames = FrameSums(
            rows=np.zeros((frames, layout.height, layout.cell), np.uint64),
            columns=np.zeros((frames, layout.cell, layout.width), np.uint64),
            tiles=np.zeros((frames, layout.sites, *layout.tiles), np.uint64),
            open=np.zeros((frames, layout.cell, layout.width), np.uint32),
        )
        self.histogram = np.zeros((2, 2, CODES if counted else 1), np.int64)

    def add(self, stack: Stack, band: Band) -> None:
        """Add a strip of every frame.

        Raises
        ------
        ValueError
            If frames and their names or sizes do not match.

        """
        if len(self._names) != stack.starts.size or stack.width != self._moments.layout.width:
            raise ValueError("frames and their names or sizes do not match")
        first, last = stack.starts.min() + band.top * stack.width, stack.starts.max() + band.bottom * stack.width
        if first < 0 or last > stack.codes.size:
            raise ValueError("a frame lies outside its block of memory")
        self._moments.add_rows(stack, band, self.frames)
        if self._counted:
            count_codes(Stack(stack.codes, stack.starts[self.places], stack.width), band, self.histogram)

    def commit(self) -> None:
        """Add what was summed up over the rows, here or by somebody else."""
        counts = by_site(self.histogram, cell=self._moments.layout.cell)
        self._moments.commit(self._names, self.frames, counted=self._counted, histogram=counts)
