"""Everything that is summed up over the frames of a series, from one reading of each.

To sum up something else: write an `Accumulator`, add it to `Accumulation`, and turn it into numbers in `finish`. Each
strip of a batch is handed to every accumulator while it is in the cache.
"""

from collections.abc import Sequence

from fullwell.statistics.batch import Accumulator, Batch
from fullwell.statistics.burst import LEGACY_FRAMES, BurstSums, burst_sums
from fullwell.statistics.finalize import finalize
from fullwell.statistics.first_look import FirstLook
from fullwell.statistics.high_pass import SMALLEST_PLANE, PassingPair
from fullwell.statistics.moments import Layout, Moments
from fullwell.statistics.pairs import PairStatistics, PairSums, pair_of_sums, pairs_of
from fullwell.statistics.series import SeriesStatistics
from fullwell.statistics.tiles import Swept
from fullwell.statistics.two_frames import add_two


class Accumulation:
    """Exact sums over the frames of a series.

    Batches may be added from several threads at once; other methods expect that nobody adds.

    Parameters
    ----------
    layout
        Size of the mosaic, its planes and tiles.
    unlit
        Whether the series is of dark or bias frames: the codes of all frames are counted then, and the first five
        frames by name, which the published read noise is made of, must be added before any other.

    """

    def __init__(self, layout: Layout, *, unlit: bool) -> None:
        self.layout = layout
        self.unlit = unlit
        self.moments = Moments(layout, every_histogram=unlit)
        self.bursts: tuple[BurstSums, ...] | None = None
        self.pairs: tuple[PairStatistics, ...] | None = None
        self.swept: Swept | None = None
        self.look = FirstLook(height=layout.height, width=layout.width, cell=layout.cell)

    @property
    def _accumulators(self) -> tuple[Accumulator, ...]:
        return (self.moments, self.look)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the frames, sorted."""
        return self.moments.names

    def clear(self, *, unlit: bool) -> None:
        """Forget all frames: memory that is used again takes no time to come by."""
        self.unlit = unlit
        self.moments.clear(every_histogram=unlit)
        self.bursts = None
        self.pairs = None
        self.swept = None
        self.expect(())

    def expect(self, names: Sequence[str]) -> None:
        """Hear which frames are the first by name: they are looked at one by one, if they come together."""
        self.look.expect(names[:LEGACY_FRAMES], products=self.unlit)

    def add(self, batch: Batch) -> None:
        """Add frames, strip by strip from the top: threads that add at once follow each other down."""
        begun = (accumulator.begin(batch) for accumulator in self._accumulators)
        additions = [addition for addition in begun if addition is not None]
        for strip in self.layout.strips():
            stack = batch.rows(strip)
            for addition in additions:
                addition.add(stack, strip)
        for addition in additions:
            addition.commit()

    def add_only_two(self, batch: Batch, *, pairs: bool = False) -> None:
        """Add two frames, which are all of the series, and keep no sums of single pixels.

        Parameters
        ----------
        batch
            The two frames, which may be read some rows of tiles at a time (`two_frames.add_two`).
        pairs
            Whether to look at them as a pair on the way. Where their codes lie so far apart that they cannot be
            filtered in passing, `pairs` stays None: `look_at_pair` needs the whole of them.

        """
        filtered = pairs and not self.unlit
        shapes = [self.layout.plane(site) for site in range(self.layout.sites)]
        passing = [PassingPair(one) if filtered and min(one) >= SMALLEST_PLANE else None for one in shapes]
        self.swept = add_two(self.moments, batch, passing)
        found = [None if one is None else one.covariance() for one in passing]
        if pairs and all(one is None or covariance is not None for one, covariance in zip(passing, found, strict=True)):
            self.pairs = tuple(
                pair_of_sums(sums, rows * columns, covariance)
                for sums, (rows, columns), covariance in zip(self._sums_of_two(batch), shapes, found, strict=True)
            )

    def look_at_pair(self, batch: Batch) -> None:
        """Keep what the first two frames of a batch tell together, where that of none is kept yet.

        Only light makes the slow variation that the high-pass filter is for.
        """
        if self.pairs is None and len(batch.names) > 1:
            sums = self._sums_of_two(batch)
            self.pairs = pairs_of(batch.stack, (0, 1), self.layout, sums=sums, filtered=not self.unlit)

    def _sums_of_two(self, batch: Batch) -> tuple[PairSums, ...]:
        """Return what is known already of two frames that are all of the series."""
        if self.swept is None:
            return ()
        totals = zip(*(self.moments.frame_sums[name] for name in batch.names), strict=True)
        maps = self.moments.maps
        extremes = zip(maps.lowest.min(axis=(1, 2)).tolist(), maps.highest.max(axis=(1, 2)).tolist(), strict=True)
        found: list[PairSums] = []
        for (first, second), tiles, own in zip(totals, self.swept.tiles, extremes, strict=True):
            differences, squares = int(tiles.spread.sum()), int(tiles.squares.sum())
            found.append(PairSums(first, second, differences, (squares - differences) // 2, own))
        return tuple(found)

    def close_burst(self) -> None:
        """Keep the sums of the first five frames, where these are all that was added so far."""
        if len(self.names) == LEGACY_FRAMES:
            self.bursts = burst_sums(self.moments)

    def merge(self, other: "Accumulation") -> None:
        """Add the frames of another accumulation of the same layout, which is left as it is.

        Raises
        ------
        ValueError
            If the layouts differ, a frame is in both, or both hold a first burst.

        """
        if self.bursts is not None and other.bursts is not None:
            raise ValueError("a series has one first burst")
        self.moments.merge(other.moments)
        self.bursts = self.bursts or other.bursts
        self.pairs = self.pairs or other.pairs
        self.look.found = self.look.found or other.look.found

    def finish(self, *, workers: int = 1) -> SeriesStatistics:
        """Return the numbers of the series, which holds at least one frame; ``workers`` as in `finalize`."""
        return finalize(self.moments, bursts=self.bursts, pairs=self.pairs, swept=self.swept, workers=workers)
