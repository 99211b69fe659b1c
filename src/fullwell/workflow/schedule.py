"""Who reads which frame: series are opened one after the other, and never more at once than there is memory for."""

from collections import deque
from collections.abc import Generator, Sequence
from threading import Condition, Event
from typing import Final

from fullwell.frames.series import Series
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.moments import Layout
from fullwell.workflow.executor import POLL_S, Progress
from fullwell.workflow.parts import UNLIT, Group, Record, first_frames, groups_of, in_order
from fullwell.workflow.stream import LostFrameError

_FEWEST_GROUPS: Final = 3
"""Taken at once, if there are so many: for fewer, going through the sums of every pixel takes longer than adding."""


class OpenSeries:
    """A series that is being reduced.

    The first five frames by name of an unlit series, which the published read noise is made of, and the frames of a
    series that has no more than five belong to the thread that opens it; the others are anybody's, who may read them
    at once but adds them after the first ones (``begun``).

    Parameters
    ----------
    series
        Its frames.
    pairs
        Whether its first two frames are wanted together.
    record
        What is known of its files, where they are read again: frames that are left out are not.

    """

    def __init__(self, series: Series, *, pairs: bool = False, record: Record | None = None) -> None:
        frames, own = in_order(series), first_frames(series, pairs=pairs)
        if record is not None:
            frames = list(record.good(frames))
        self.series = series
        self.first = groups_of(frames[:own])
        self.rest = deque(groups_of(frames[own:]))
        self.busy = 0
        self.begun = Event()
        self.record = record or Record()
        self.spoilt = False
        self._sums: Accumulation | None = None

    def open(self, sums: Accumulation) -> None:
        """Take empty sums to add to."""
        self._sums = sums

    def lose(self, lost: LostFrameError) -> None:
        """Leave a frame out that failed while it was added, so that the sums are of no use."""
        self.record.exclude(lost.frame, lost.cause)
        self.spoilt = True
        self.begun.set()

    def release(self) -> Accumulation:
        """Let the sums go."""
        sums, self._sums = self.sums, None
        return sums

    @property
    def sums(self) -> Accumulation:
        """Return the sums of an open series."""
        if self._sums is None:
            raise RuntimeError("the series is not open")
        return self._sums


class Schedule:
    """Hands frames to threads.

    Parameters
    ----------
    series
        In the order they are opened.
    most_open
        Series that may be open at once.
    pairs
        As `OpenSeries`.
    progress
        Told of every frame.

    """

    def __init__(
        self, series: Sequence[Series], *, most_open: int, pairs: bool = False, progress: Progress | None = None
    ) -> None:
        self._pairs = pairs
        self._waiting = deque((one, Record(progress=progress)) for one in series)
        self._open: list[OpenSeries] = []
        self._spare: list[Accumulation] = []
        self._most_open = most_open
        self._changed = Condition()

    def take(self, stop: Event) -> tuple[OpenSeries, bool] | None:
        """Return a series to work on and whether its first frames are still to be read; None when all is done."""
        with self._changed:
            while not stop.is_set():
                for opened in self._open:
                    if opened.rest:
                        opened.busy += 1
                        return opened, False
                if self._waiting and len(self._open) < self._most_open:
                    series, record = self._waiting.popleft()
                    opened = OpenSeries(series, pairs=self._pairs, record=record)
                    opened.busy += 1
                    self._open.append(opened)
                    return opened, True
                if not self._waiting and not any(opened.rest for opened in self._open):
                    return None
                self._changed.wait(POLL_S)
        return None

    def next_groups(self, opened: OpenSeries, *, workers: int) -> Generator[Group]:
        """Yield some of the frames that are anybody's: not so many that other threads wait for the last of them."""
        with self._changed:
            most = max(-(-len(opened.rest) // workers), _FEWEST_GROUPS)
        for _ in range(most):
            with self._changed:
                if not opened.rest:
                    return
                group = opened.rest.popleft()
            yield group

    def wait_for_burst(self, opened: OpenSeries, stop: Event) -> bool:
        """Return True once the first frames of a series have been added, False where all shall stop."""
        while not stop.is_set():
            if opened.begun.wait(POLL_S):
                return True
        return False

    def give_back(self, opened: OpenSeries) -> bool:
        """Say that a thread is done with what it took; return True if the series is complete with it."""
        with self._changed:
            opened.busy -= 1
            return not opened.rest and opened.busy == 0

    @property
    def over(self) -> bool:
        """Tell whether no thread has anything to read, so that those that are left may be used for something else."""
        with self._changed:
            return not self._waiting and not any(opened.busy or opened.rest for opened in self._open)

    def begin(self, opened: OpenSeries, layout: Layout) -> None:
        """Give a series its sums: those of a finished one if there are any, since new memory takes its time."""
        unlit = opened.series.kind in UNLIT
        with self._changed:
            spare = self._spare.pop() if self._spare else None
        if spare is not None:
            spare.clear(unlit=unlit)
        sums = spare or Accumulation(layout, unlit=unlit)
        sums.expect([frame.name for frame in in_order(opened.series)])
        opened.open(sums)

    def close(self, opened: OpenSeries, *, again: bool = False) -> None:
        """Let a finished series go, so that the next may be opened; or the same once more, without its lost frames."""
        with self._changed:
            if again:
                self._waiting.appendleft((opened.series, opened.record))
            self._spare.append(opened.release())
            self._open.remove(opened)
            self._changed.notify_all()
