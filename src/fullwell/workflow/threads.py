"""Series are reduced by the threads of one machine, each file read once, in bounded memory.

A thread takes some frames of a series, reads, hashes and decodes them, strip by strip where it can (`slots`), and adds
each strip to the sums of the series. Frames may come in any order but for the first of a series, because sums merge
exactly.
"""

from collections.abc import Sequence
from threading import Event

from fullwell.frames.series import Series
from fullwell.statistics.burst import LEGACY_FRAMES
from fullwell.workflow.executor import Progress, run_threads
from fullwell.workflow.parts import UNLIT, Group, add_groups, outcome_of, read_group
from fullwell.workflow.plan import Done, Plan
from fullwell.workflow.schedule import OpenSeries, Schedule
from fullwell.workflow.slots import Slots, StoppedError
from fullwell.workflow.stream import LostFrameError


def reduce_in_threads(series: Sequence[Series], *, plan: Plan, done: Done, progress: Progress | None) -> None:
    """Reduce some series.

    Parameters
    ----------
    series
        Each with at least one frame.
    plan
        How many frames are read at once, and by how many threads.
    done
        Told what each series came to.
    progress
        Told of every frame.

    """
    schedule = Schedule(series, most_open=plan.most_open, pairs=plan.pairs, progress=progress)
    reducer = _Reducer(schedule=schedule, plan=plan, done=done)
    run_threads(reducer.work, workers=plan.workers)


class _Reducer:
    """What the threads of one reduction share."""

    def __init__(self, *, schedule: Schedule, plan: Plan, done: Done) -> None:
        self._schedule = schedule
        self._plan = plan
        self._done = done

    def work(self, _index: int, stop: Event) -> None:
        """Add frames until there are none left, as one thread of several."""
        plan = self._plan
        slots = Slots(slots=plan.slots, slot_bytes=plan.slot_bytes, layout=plan.layout, stop=stop)
        try:
            while (task := self._schedule.take(stop)) is not None:
                self._do(*task, slots, stop)
        except StoppedError:
            return
        finally:
            slots.clear()

    def _do(self, opened: OpenSeries, first: bool, slots: Slots, stop: Event) -> None:  # noqa: FBT001 - as `take` returns it
        try:
            if first:
                self._add_first(opened, slots, stop)
            else:
                self._add_some(opened, slots, stop)
        except LostFrameError as lost:
            opened.lose(lost)
        slots.clear()
        if self._schedule.give_back(opened) and not stop.is_set():
            if not opened.spoilt:
                self._finish(opened, slots)
            self._schedule.close(opened, again=opened.spoilt)

    def _finish(self, opened: OpenSeries, slots: Slots) -> None:
        """Tell what a series came to, unless a frame fails that is read once more."""
        workers = self._plan.workers if self._schedule.over else 1
        try:
            outcome = outcome_of(opened.series, opened.sums, opened.record, slots, workers=workers)
        except LostFrameError as lost:
            opened.lose(lost)
        else:
            self._done(opened.series, outcome)

    def _add_first(self, opened: OpenSeries, slots: Slots, stop: Event) -> None:
        """Add the first frames of a series before any other, and keep their sums where more are to come."""
        self._schedule.begin(opened, self._plan.layout)
        groups = (group for group in opened.first if not stop.is_set())
        only_two = self._plan.only_two(opened.series)
        add_groups(groups, opened.sums, slots, opened.record, pairs=self._plan.pairs, only_two=only_two)
        if opened.series.kind in UNLIT and len(opened.series.frames) > LEGACY_FRAMES:
            opened.sums.close_burst()
        opened.begun.set()

    def _add_some(self, opened: OpenSeries, slots: Slots, stop: Event) -> None:
        """Add some of the other frames of a series: as many as there is room for, so that the maps are touched rarely.

        Frames are taken two by two, so that all threads come to the end together.
        """
        pairs: list[Group] = []
        for group in self._schedule.next_groups(opened, workers=self._plan.workers):
            read_group(group, slots, opened.record)
            pairs.append(group)
            if stop.is_set() or not slots.fits(2):
                break
        if not slots.empty and self._schedule.wait_for_burst(opened, stop):
            opened.sums.add(slots.batch(pairs))
