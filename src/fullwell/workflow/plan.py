"""How the frames of a study are read: by how many at once, with how much memory, and where the outcome goes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol

from fullwell.frames.series import Series, SeriesKey
from fullwell.statistics.burst import LEGACY_FRAMES
from fullwell.statistics.moments import Layout
from fullwell.workflow.executor import Progress
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.slots import MOST_FRAMES, passes, slot_bytes_to_pass
from fullwell.workflow.stream import streams

MOST_BUFFER_BYTES: Final = 400_000_000
"""Of the files and mosaics that all threads hold [byte]."""
MOST_MAP_BYTES: Final = 400_000_000
"""Of the sums of all series that are open [byte]."""
MOST_SLOTS: Final = 5
"""Whole frames a thread holds at once: a first burst. More touch the maps more rarely, but memory takes its time."""
_MAP_BYTES_PER_PIXEL: Final = 12
"""What they take: 8, and up to 16 where codes are so large that squares are summed in 64 bits as well [byte]."""

Done = Callable[[Series, SeriesOutcome], None]
"""Told of every series once, from any thread; ``sums`` of the outcome are only there until it returns."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How series are read.

    Parameters
    ----------
    layout
        Of the mosaics.
    workers
        Threads.
    slots
        Frames a thread holds at once.
    slot_bytes
        Room for the largest file and for a mosaic; or for a strip, where none is needed as a whole.
    most_open
        Series that may be open at once.
    pairs
        Whether the first two frames of each series are also looked at as a pair.
    kept
        Series whose sums of single pixels are wanted; those of others need not be there in the outcome.

    """

    layout: Layout
    workers: int
    slots: int
    slot_bytes: int
    most_open: int
    pairs: bool = False
    kept: frozenset[SeriesKey] = frozenset()

    def only_two(self, series: Series) -> bool:
        """Tell whether a series has two frames, and nobody wants their sums of single pixels."""
        return len(series.frames) == 2 and series.key not in self.kept


class Cluster(Protocol):
    """Processes on this machine or others, which see the same files."""

    def reduce(self, series: Sequence[Series], *, plan: Plan, done: Done, progress: Progress | None) -> None:
        """Reduce some series, as `threads.reduce_in_threads` does."""
        ...


def plan(
    series: Sequence[Series],
    layout: Layout,
    *,
    workers: int,
    pairs: bool = False,
    kept: frozenset[SeriesKey] = frozenset(),
) -> Plan:
    """Return how to read some series in bounded memory."""
    frames = [frame for one in series for frame in one.frames]
    workers = max(1, min(workers, len(frames)))
    pixels = layout.height * layout.width
    how = Plan(
        layout=layout,
        workers=workers,
        slots=MOST_FRAMES,
        slot_bytes=layout.strip_bytes,
        most_open=max(1, min(workers, MOST_MAP_BYTES // (_MAP_BYTES_PER_PIXEL * pixels))),
        pairs=pairs,
        kept=kept,
    )
    if not pairs and all(map(streams, frames)) and not any(map(how.only_two, series)):
        return how
    # New memory costs more than it saves where few frames use it; a first burst should fit all the same.
    useful = max(LEGACY_FRAMES, -(-len(frames) // (3 * workers)))
    if not pairs and all(map(passes, frames)) and not any(map(how.only_two, series)):
        slot_bytes = slot_bytes_to_pass(frames, layout)
        file_bytes = slot_bytes + max(frame.size for frame in frames)
        slots = max(2, min(MOST_SLOTS, useful, MOST_BUFFER_BYTES // (workers * file_bytes)))
        return replace(how, slots=slots, slot_bytes=slot_bytes)
    slot_bytes = max([2 * pixels, layout.strip_bytes, *(frame.size for frame in frames)])
    apart = any(frame.header.compression != "none" for frame in frames)
    affordable = MOST_BUFFER_BYTES // (workers * slot_bytes) - apart
    slots = max(LEGACY_FRAMES if pairs else 2, min(MOST_SLOTS, useful, affordable))
    return replace(how, slots=slots, slot_bytes=slot_bytes)
