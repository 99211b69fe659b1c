"""Series are reduced by the threads of one machine, each file read once, in bounded memory.

A thread takes a few frames of a series, reads, hashes and decodes them, and adds them to the sums of the series a row
of tiles at a time. Frames may come in any order but for the first of a series, because sums merge exactly.
"""

from collections.abc import Sequence
from threading import Event

from fullwell.frames.series import Series
from fullwell.statistics.burst import LEGACY_FRAMES
from fullwell.workflow.executor import Progress, run_threads
from fullwell.workflow.parts import UNLIT, Group, add_groups, outcome_of, read_group
from fullwell.workflow.plan import Done, Plan
from fullwell.workflow.schedule import OpenSeries, Schedule
from fullwell.workflow.slots import Slots


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
    schedule = Schedule(series, most_open=plan.most_open, pairs=plan.pairs)
    reducer = _Reducer(schedule=schedule, plan=plan, done=done, progress=progress)
    run_threads(reducer.work, workers=plan.workers)


class _Reducer:
    """What the threads of one reduction share."""

    def __init__(self, *, schedule: Schedule, plan: Plan, done: Done, progress: Progress | None) -> None:
        self._schedule = schedule
        self._plan = plan
        self._done = done
        self._progress = progress

    def work(self, index: int, stop: Event) -> None:
        """Add frames until there are none left, as one thread of several."""
        slots = Slots(slots=self._plan.slots, slot_bytes=self._plan.slot_bytes, layout=self._plan.layout)
        first_band = index * len(self._plan.layout.bands()) // self._plan.workers
        while (task := self._schedule.take(stop)) is not None:
            opened, first = task
            slots.clear()
            if first:
                self._add_first(opened, slots, stop)
            else:
                self._add_some(opened, slots, stop, first_band=first_band)
            if self._schedule.give_back(opened) and not stop.is_set():
                self._done(opened.series, outcome_of(opened.series, opened.sums, opened.record, slots))
                self._schedule.close(opened)

    def _add_first(self, opened: OpenSeries, slots: Slots, stop: Event) -> None:
        """Add the first frames of a series before any other, and keep their sums where more are to come."""
        self._schedule.begin(opened, self._plan.layout)
        groups = (group for group in opened.first if not stop.is_set())
        add_groups(
            groups,
            opened.sums,
            slots,
            opened.record,
            pairs=self._plan.pairs,
            only_two=len(opened.series.frames) == 2 and opened.series.key not in self._plan.kept,
            progress=self._progress,
        )
        if opened.series.kind in UNLIT and len(opened.series.frames) > LEGACY_FRAMES:
            opened.sums.close_burst()
        opened.begun.set()

    def _add_some(self, opened: OpenSeries, slots: Slots, stop: Event, *, first_band: int) -> None:
        """Add some of the other frames of a series: as many as there is room for, so that the maps are touched rarely.

        Frames are taken two by two, so that all threads come to the end together.
        """
        pairs: list[Group] = []
        while slots.fits(2) and not stop.is_set() and (group := self._schedule.next_group(opened)):
            read_group(group, slots, opened.record, self._progress)
            pairs.append(group)
        if not slots.empty and self._schedule.wait_for_burst(opened, stop):
            opened.sums.add(slots.batch(pairs), first_band=first_band)
