"""A part of a series becomes sums, and the sums of all parts become what its frames come to; by whom is another matter.

Threads of one machine add parts to the same sums (`threads`); processes of many machines make their own and merge them
(`cluster`). Both use what is here, so that they say the same.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from fullwell.errors import RawFileError
from fullwell.frames.series import Exclusion, Frame, Kind, Series
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.batch import Batch
from fullwell.statistics.burst import LEGACY_FRAMES, BurstSums, burst_sums
from fullwell.statistics.moments import Layout
from fullwell.workflow.executor import Progress
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.slots import Slots
from fullwell.workflow.stream import LostFrameError

UNLIT: Final = frozenset({Kind.DARK, Kind.BIAS})

Group = tuple[Frame, ...]
"""Two frames that follow each other by name, or the last of an odd number: one thread reads them, into one batch."""


@dataclass(slots=True, kw_only=True)
class Record:
    """What was learnt of the files of a series while they were read; several threads may write to it.

    Parameters
    ----------
    hashes
        xxh3-128 of every file that could be read, by frame name.
    excluded
        Frames that turned out to be damaged.
    progress
        Told of every frame, once.

    """

    hashes: dict[str, str] = field(default_factory=dict)
    excluded: list[Exclusion] = field(default_factory=list)
    progress: Progress | None = None
    _heard: set[str] = field(default_factory=set)

    def read(self, frame: Frame, digest: str) -> None:
        """Keep the hash of a file that was read."""
        self.hashes[frame.name] = digest
        self._hear(frame)

    def exclude(self, frame: Frame, error: RawFileError | OSError) -> None:
        """Leave a frame out, and keep why."""
        self.excluded.append(Exclusion.of(frame.name, error))
        self._hear(frame)

    def good(self, frames: Iterable[Frame]) -> tuple[Frame, ...]:
        """Return those that have not been left out."""
        bad = {one.name for one in self.excluded}
        return tuple(frame for frame in frames if frame.name not in bad)

    def _hear(self, frame: Frame) -> None:
        if self.progress is not None and frame.name not in self._heard:
            self._heard.add(frame.name)
            self.progress.advance()


def in_order(series: Series) -> list[Frame]:
    """Return the frames of a series by name."""
    return sorted(series.frames, key=lambda frame: frame.name)


def first_frames(series: Series, *, pairs: bool) -> int:
    """Return how many frames, by name, are added before any other.

    These are the first five of an unlit series, which the published read noise is made of (METHOD 3.2), all of a series
    that has no more than five, and the first five of any series whose first two are wanted together.
    """
    return LEGACY_FRAMES if pairs or series.kind in UNLIT or len(series.frames) <= LEGACY_FRAMES else 0


def groups_of(frames: Sequence[Frame]) -> tuple[Group, ...]:
    """Return frames two by two."""
    return tuple(tuple(frames[at : at + 2]) for at in range(0, len(frames), 2))


def read_group(group: Group, slots: Slots, record: Record, *, whole: bool = False, two: bool = False) -> None:
    """Read frames into slots, or leave them out and say why; ``whole`` and ``two`` as in `Slots.read`."""
    for frame in group:
        try:
            slots.read(frame, record.read, whole=whole, two=two)
        except (RawFileError, OSError) as error:
            record.exclude(frame, error)


def add_groups(
    groups: Iterable[Group],
    sums: Accumulation,
    slots: Slots,
    record: Record,
    *,
    pairs: bool = False,
    only_two: bool = False,
) -> None:
    """Read frames and add them, as many at once as there is room for.

    Parameters
    ----------
    groups
        The frames.
    sums, record
        Added to.
    slots
        Memory to read them into.
    pairs
        Whether the first two good frames are looked at together.
    only_two
        Whether these are the two frames of a series whose sums of single pixels nobody wants.

    Raises
    ------
    LostFrameError
        A frame failed while it was added: the sums are of no use.

    """
    slots.clear()
    some: list[Group] = []
    try:
        for group in groups:
            if not slots.fits(len(group)):
                _add_batch(slots.batch(some), sums, pairs=pairs)
                slots.clear()
            read_group(group, slots, record, whole=pairs and not only_two, two=only_two)
            some.append(group)
        batch = slots.batch(some)
        if only_two and len(batch.names) == 2:
            sums.add_only_two(batch, pairs=pairs)
            if pairs and sums.pairs is None:
                slots.clear()
                read_group(some[0], slots, Record(), whole=True)
                sums.look_at_pair(slots.batch())
        elif not slots.empty:
            _add_batch(batch, sums, pairs=pairs)
    finally:
        slots.clear()


def _add_batch(batch: Batch, sums: Accumulation, *, pairs: bool) -> None:
    sums.add(batch)
    if pairs:
        sums.look_at_pair(batch)


def outcome_of(series: Series, sums: Accumulation, record: Record, slots: Slots, *, workers: int = 1) -> SeriesOutcome:
    """Return what a series comes to once all its frames are added; ``sums`` of the outcome are those of the maps.

    Where one of the first five frames of an unlit series is damaged, the first five good ones are read once more.

    Raises
    ------
    LostFrameError
        One of these fails now: the sums hold a frame that cannot be relied on.

    """
    names = sums.names
    if series.kind in UNLIT and len(names) > LEGACY_FRAMES and sums.bursts is None:
        sums.bursts = _burst_again(series, names[:LEGACY_FRAMES], sums.layout, slots)
    return SeriesOutcome(
        statistics=sums.finish(workers=workers) if names else None,
        hashes=dict(sorted(record.hashes.items())),
        excluded=tuple(sorted(record.excluded, key=lambda one: one.name)),
        sums=sums.moments.maps.codes if names and sums.swept is None else None,
        first=sums.look.found,
    )


def _burst_again(series: Series, names: Sequence[str], layout: Layout, slots: Slots) -> tuple[BurstSums, ...]:
    sums, record = Accumulation(layout, unlit=False), Record()
    for frame in series.frames:
        if frame.name in names:
            try:
                slots.read(frame, record.read)
                sums.add(slots.batch())
            except (RawFileError, OSError) as error:
                raise LostFrameError(frame, error) from error
            finally:
                slots.clear()
    return burst_sums(sums.moments)
