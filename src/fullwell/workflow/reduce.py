"""A study's frames become statistics: each file is read once, by any number of threads, in bounded memory.

A worker takes a few frames of a series, reads, hashes and decodes them, and adds them to the series' moments a row of
tiles at a time. The first five frames by name of an unlit series are added before any other: they are the burst that
the published read-noise flows need (METHOD 3.2). Everything else may come in any order, because moments merge exactly;
so the results are the same for any number of workers. Only where one of those five is damaged are the first five good
ones read a second time.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UsageError
from fullwell.findings import Finding
from fullwell.frames.checks import exclusion_findings
from fullwell.frames.series import Exclusion, Frame, Kind, Series, SeriesKey, Study
from fullwell.statistics.batch import Batch
from fullwell.statistics.burst import LEGACY_FRAMES, BurstSums, burst_sums
from fullwell.statistics.moments import Layout, Moments
from fullwell.statistics.series import SeriesStatistics
from fullwell.workflow.executor import Progress, run_threads
from fullwell.workflow.schedule import Group, OpenSeries, Schedule
from fullwell.workflow.scratch import KeptSums
from fullwell.workflow.slots import Slots

MOST_BUFFER_BYTES: Final = 400_000_000
MOST_MAP_BYTES: Final = 400_000_000
MOST_SLOTS: Final = 8
"""Frames a thread holds at once: the more, the more rarely the maps are touched."""
_MAP_BYTES_PER_PIXEL: Final = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Reduction:
    """What the frames of a study come to.

    Parameters
    ----------
    statistics
        By `Series.key`, in the study's order; a series without a single good frame is missing.
    hashes
        xxh3-128 of every file that could be read, by frame name, sorted.
    excluded
        Frames that turned out to be damaged, sorted by name.
    findings
        The same for the report, one per reason.
    sums
        By `Series.key`, in the study's order: sum over the good frames of each pixel, shape (height, width), of series
        whose kinds were to be kept; read-only [DN].

    """

    statistics: Mapping[SeriesKey, SeriesStatistics]
    hashes: Mapping[str, str]
    excluded: tuple[Exclusion, ...]
    findings: tuple[Finding, ...]
    sums: Mapping[SeriesKey, NDArray[np.uint32]] = field(default_factory=dict)


def reduce_study(
    study: Study,
    *,
    workers: int,
    tile: int = 64,
    progress: Progress | None = None,
    keep: Collection[Kind] = (),
    scratch: Path | None = None,
    pairs: bool = False,
    least_kept: int = 1,
) -> Reduction:
    """Read every frame of a study once and return the statistics of its series.

    Parameters
    ----------
    study
        Frames in series.
    workers
        Threads; the result does not depend on their number.
    tile
        Edge of a tile [pixel of a plane].
    progress
        Told of every frame.
    keep
        Kinds of series whose sums are kept pixel by pixel.
    scratch
        Folder for these sums where all together take more than 1 GB; the caller's, who removes it when they are no
        longer used.
    pairs
        Whether the first two frames of each series are also looked at as a pair.
    least_kept
        Frames that a series has at least for its sums to be kept.

    Raises
    ------
    UsageError
        The frames are too small or too large, or the tile is.
    ValueError
        The sums take more than 1 GB and there is no folder for them.

    """
    layout = _layout(study, tile)
    series = [one for one in study.series if one.frames]
    frames = [frame for one in series for frame in one.frames]
    pixels = study.height * study.width
    kept = KeptSums(series, kinds=keep, pixels=pixels, folder=scratch, least=least_kept)
    if progress is not None:
        progress.start(len(frames))
    slot_bytes = max([2 * pixels, *(frame.size for frame in frames)])
    workers = max(1, min(workers, len(frames)))
    # New memory costs more than it saves where few frames use it; a first burst should fit all the same.
    useful = max(LEGACY_FRAMES, -(-len(frames) // (8 * workers)))
    apart = any(frame.header.compression != "none" for frame in frames)
    slots = max(2, min(MOST_SLOTS, useful, MOST_BUFFER_BYTES // (workers * slot_bytes) - apart))
    most_open = max(1, min(workers, MOST_MAP_BYTES // (_MAP_BYTES_PER_PIXEL * pixels)))
    schedule = Schedule(series, most_open=most_open, workers=workers, pairs=pairs)
    task = _Reducer(schedule=schedule, layout=layout, slots=slots, slot_bytes=slot_bytes, kept=kept, progress=progress)
    run_threads(task.work, workers=workers)
    return task.reduction(series)


def _layout(study: Study, tile: int) -> Layout:
    try:
        return Layout(height=study.height, width=study.width, cfa=study.cfa, tile=tile)
    except ValueError as error:
        raise UsageError(str(error)) from error


class _Reducer:
    """What the threads of one reduction share."""

    def __init__(
        self,
        *,
        schedule: Schedule,
        layout: Layout,
        slots: int,
        slot_bytes: int,
        kept: KeptSums,
        progress: Progress | None,
    ) -> None:
        self._schedule = schedule
        self._layout = layout
        self._slots = slots
        self._slot_bytes = slot_bytes
        self._kept = kept
        self._progress = progress
        self._statistics: dict[SeriesKey, SeriesStatistics] = {}
        self._hashes: dict[str, str] = {}
        self._excluded: list[Exclusion] = []

    def work(self, index: int, stop: Event) -> None:
        """Add frames until there are none left, as one thread of several."""
        layout = self._layout
        slots = Slots(slots=self._slots, slot_bytes=self._slot_bytes, height=layout.height, width=layout.width)
        first_band = index * len(layout.bands()) // self._schedule.workers
        while (task := self._schedule.take(stop)) is not None:
            opened, first = task
            slots.clear()
            if first:
                self._add_first(opened, slots, stop)
            else:
                self._add_some(opened, slots, stop, first_band=first_band)
            if self._schedule.give_back(opened) and not stop.is_set():
                self._finish(opened, slots)

    def _add_first(self, opened: OpenSeries, slots: Slots, stop: Event) -> None:
        """Add the first frames of a series before any other, and keep their sums where more are to come."""
        self._schedule.begin(opened, self._layout)
        pairs: list[Group] = []
        for group in opened.first:
            if stop.is_set():
                return
            if not slots.fits(len(group)):
                self._add_batch(opened, slots.batch(pairs))
                slots.clear()
            self._read(group, opened, slots)
            pairs.append(group)
        if not slots.empty:
            self._add_batch(opened, slots.batch(pairs))
        if opened.unlit and len(opened.series.frames) > LEGACY_FRAMES:
            opened.sums.close_burst()
        opened.begun.set()

    def _add_batch(self, opened: OpenSeries, batch: Batch) -> None:
        """Add some of the first frames of a series; the first two good ones are looked at together where wanted."""
        if opened.pairs:
            opened.sums.look_at_pair(batch)
        opened.sums.add(batch)

    def _add_some(self, opened: OpenSeries, slots: Slots, stop: Event, *, first_band: int) -> None:
        """Add some of the other frames of a series: as many as there is room for, so that the maps are touched rarely.

        Frames are taken two by two, so that all threads come to the end together.
        """
        pairs: list[Group] = []
        while slots.fits(2) and not stop.is_set() and (group := self._schedule.next_group(opened)):
            self._read(group, opened, slots)
            pairs.append(group)
        if not slots.empty and self._schedule.wait_for_burst(opened, stop):
            opened.sums.add(slots.batch(pairs), first_band=first_band)

    def _read(self, group: Group, opened: OpenSeries, slots: Slots) -> None:
        """Read frames into slots, or leave them out and say why."""
        for frame in group:
            try:
                slots.read(frame, opened.hashes)
            except (RawFileError, OSError) as error:
                opened.excluded.append(exclusion_of(frame, error))
            if self._progress is not None:
                self._progress.advance()

    def _finish(self, opened: OpenSeries, slots: Slots) -> None:
        """Turn the complete sums of a series into statistics and let their maps go."""
        sums = opened.sums
        if opened.unlit and len(sums.names) > LEGACY_FRAMES and sums.bursts is None:
            sums.bursts = self._burst_again(opened, sums.names[:LEGACY_FRAMES], slots)
        self._hashes.update(opened.hashes)
        self._excluded += opened.excluded
        if sums.names:
            self._kept.keep(opened.series.key, sums.moments.maps.codes)
            self._statistics[opened.series.key] = sums.finish()
        self._schedule.close(opened)

    def _burst_again(self, opened: OpenSeries, names: Sequence[str], slots: Slots) -> tuple[BurstSums, ...]:
        """Read the first good frames of a series once more, where some of the first were damaged."""
        moments = Moments(self._layout)
        for frame in opened.series.frames:
            if frame.name in names:
                slots.clear()
                slots.read(frame, opened.hashes)
                batch = slots.batch()
                moments.add(batch.names, batch.stack)
        return burst_sums(moments)

    def reduction(self, series: Sequence[Series]) -> Reduction:
        """Return what was found, in an order that does not depend on the threads."""
        excluded = tuple(sorted(self._excluded, key=lambda one: one.name))
        return Reduction(
            statistics={one.key: self._statistics[one.key] for one in series if one.key in self._statistics},
            hashes=dict(sorted(self._hashes.items())),
            excluded=excluded,
            findings=exclusion_findings(excluded),
            sums=self._kept.sums(series),
        )


def exclusion_of(frame: Frame, error: RawFileError | OSError) -> Exclusion:
    """Return why a frame is left out that could not be read."""
    if isinstance(error, RawFileError):
        return Exclusion(name=frame.name, code=error.code, reason=error.message)
    if isinstance(error, FileNotFoundError):
        return Exclusion(name=frame.name, code="file-missing", reason="the file does not exist")
    reason = f"the file cannot be read ({error.strerror or error})"
    return Exclusion(name=frame.name, code="file-unreadable", reason=reason)
