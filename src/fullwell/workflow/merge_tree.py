"""A study as tasks for many processes: parts become sums, sums are merged two by two, the last one is finished.

A series of a few frames is one task. A longer one is cut into parts by name, each a task that makes sums of its own.
Sums are exact, so neither the cutting, nor the order of merging, nor a task that is done twice changes a bit. Who runs
the tasks is no matter here (`cluster`).
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, Final

from fullwell.frames.series import Frame, Series
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.moments import Layout
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.parts import UNLIT, Record, add_groups, first_frames, groups_of, in_order, outcome_of
from fullwell.workflow.plan import MOST_SLOTS
from fullwell.workflow.slots import Slots, passes, slot_bytes_to_pass
from fullwell.workflow.stream import LostFrameError

PART_FRAMES: Final = 16
"""Frames of a task besides a first burst; even, so that pairs stay together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Some frames of a series that one task reads.

    Parameters
    ----------
    layout
        Of the mosaics.
    unlit
        Whether the series is of dark or bias frames.
    pairs
        Whether the first two frames of the series are looked at together.
    names
        Of all frames of the series.
    first, rest
        Which, by name: those that belong to the first burst, and others.

    """

    layout: Layout
    unlit: bool
    pairs: bool
    names: tuple[str, ...]
    first: tuple[Frame, ...]
    rest: tuple[Frame, ...]

    @property
    def frames(self) -> tuple[Frame, ...]:
        """Return all of them."""
        return (*self.first, *self.rest)


@dataclass(frozen=True, slots=True, kw_only=True)
class Summed:
    """What one part or several come to."""

    sums: Accumulation
    record: Record


def parts_of(series: Series, layout: Layout, *, pairs: bool = False) -> list[Part]:
    """Cut a series into parts; ``pairs`` as in `Part`."""
    frames, own = in_order(series), first_frames(series, pairs=pairs)
    starts = range(own, max(len(frames), own + 1), PART_FRAMES)
    return [
        Part(
            layout=layout,
            unlit=series.kind in UNLIT,
            pairs=pairs,
            names=tuple(frame.name for frame in frames),
            first=tuple(frames[:own]) if start == own else (),
            rest=tuple(frames[start : start + PART_FRAMES]),
        )
        for start in starts
    ]


def sum_part(part: Part) -> Summed:
    """Read the frames of a part; runs where the files are to be read."""
    record, slots = Record(), _slots(part.frames, part.layout, pairs=part.pairs)
    while True:
        sums = Accumulation(part.layout, unlit=part.unlit)
        sums.expect(part.names)
        try:
            _add(part, sums, slots, record)
        except LostFrameError as lost:
            record.exclude(lost.frame, lost.cause)
        else:
            return Summed(sums=sums, record=record)


def _add(part: Part, sums: Accumulation, slots: Slots, record: Record) -> None:
    """Add the frames of a part that have not been left out."""
    if part.first:
        add_groups(groups_of(record.good(part.first)), sums, slots, record, pairs=part.pairs)
        if part.unlit:
            sums.close_burst()
    if part.rest:
        add_groups(groups_of(record.good(part.rest)), sums, slots, record)


def merge(one: Summed, other: Summed) -> Summed:
    """Return the sums over both; neither is changed, since either may be asked for again."""
    sums = Accumulation(one.sums.layout, unlit=one.sums.unlit)
    sums.merge(one.sums)
    sums.merge(other.sums)
    record = Record(
        hashes=one.record.hashes | other.record.hashes, excluded=[*one.record.excluded, *other.record.excluded]
    )
    return Summed(sums=sums, record=record)


def finish(series: Series, summed: Summed) -> SeriesOutcome:
    """Return what a series comes to; it is read again without a frame that fails when it is read once more."""
    sums, record = summed.sums, summed.record
    try:
        return outcome_of(series, sums, record, _slots(series.frames, sums.layout))
    except LostFrameError as lost:
        record = Record(hashes=record.hashes, excluded=[*record.excluded])
        record.exclude(lost.frame, lost.cause)
    good = replace(series, frames=record.good(series.frames))
    parts = map(sum_part, parts_of(good, sums.layout, pairs=sums.pairs is not None))
    nothing = Summed(sums=Accumulation(sums.layout, unlit=sums.unlit), record=record)
    return finish(series, reduce(merge, parts, nothing))


def reduce_whole(series: Series, part: Part) -> SeriesOutcome:
    """Reduce a series that is a single part."""
    return finish(series, sum_part(part))


def _slots(frames: Sequence[Frame], layout: Layout, *, pairs: bool = False) -> Slots:
    if not pairs and all(map(passes, frames)):
        return Slots(slots=max(2, len(frames)), slot_bytes=slot_bytes_to_pass(frames, layout), layout=layout)
    slot_bytes = max([2 * layout.height * layout.width, layout.strip_bytes, *(frame.size for frame in frames)])
    return Slots(slots=max(2, min(MOST_SLOTS, len(frames))), slot_bytes=slot_bytes, layout=layout)


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A function to call where there is room, and what to call it with: handles of other results among it.

    Parameters
    ----------
    work, arguments
        The function and its arguments.
    series
        Whose frames it is about.
    frames
        How many it reads.
    last
        Whether it returns the outcome of the series.

    """

    work: Callable[..., object]
    arguments: tuple[Any, ...]
    series: Series
    frames: int = 0
    last: bool = False


@dataclass(slots=True)
class _Branch:
    """A series on its way: tasks that have not ended, and the handle that waits for another to be merged with."""

    pending: int
    ready: object = None


class MergeTree:
    """What is still to be done for some series.

    Parameters
    ----------
    series
        Each with at least one frame.
    layout
        Of the mosaics.
    pairs
        As in `Part`.

    """

    def __init__(self, series: Sequence[Series], layout: Layout, *, pairs: bool = False) -> None:
        cut = [(one, parts_of(one, layout, pairs=pairs)) for one in series]
        self._waiting = deque((one, part, len(parts)) for one, parts in cut for part in parts)
        self._branches = {one.key: _Branch(pending=len(parts)) for one, parts in cut}

    def next_part(self) -> Task | None:
        """Return the next task that reads frames; None when there is none left."""
        if not self._waiting:
            return None
        series, part, parts = self._waiting.popleft()
        frames = len(part.frames)
        if parts == 1:
            return Task(work=reduce_whole, arguments=(series, part), series=series, frames=frames, last=True)
        return Task(work=sum_part, arguments=(part,), series=series, frames=frames)

    def following(self, task: Task, handle: object) -> Task | None:
        """Return what can be done now that a task has ended, ``handle`` standing for what it returned."""
        branch = self._branches[task.series.key]
        branch.pending -= 1
        if task.last:
            return None
        if branch.ready is not None:
            arguments, branch.ready = (branch.ready, handle), None
            branch.pending += 1
            return Task(work=merge, arguments=arguments, series=task.series)
        if branch.pending:
            branch.ready = handle
            return None
        branch.pending += 1
        return Task(work=finish, arguments=(task.series, handle), series=task.series, last=True)
