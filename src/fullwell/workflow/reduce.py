"""A study's frames become statistics: what is known of finished series is used, the others are read.

The results are the same for any number of threads, on one machine or many, and for what a run that was cut short has
left (`parts`, `threads`, `cluster`, `cache`).
"""

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.findings import Finding
from fullwell.frames.checks import exclusion_findings
from fullwell.frames.series import Exclusion, Kind, Series, SeriesKey, Study
from fullwell.statistics.first_look import FirstFrames
from fullwell.statistics.moments import Layout
from fullwell.statistics.pixels import PixelSums
from fullwell.statistics.series import SeriesStatistics
from fullwell.workflow.cache.recipe import recipe
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.executor import Progress
from fullwell.workflow.outcome import SeriesOutcome
from fullwell.workflow.plan import Cluster, plan
from fullwell.workflow.read_ahead import ReadAhead, Stoppable
from fullwell.workflow.scratch import KeptSums, narrowed
from fullwell.workflow.threads import reduce_in_threads

_FEWEST_LINES: Final = 2
"""Rows and columns of a plane whose noise is told apart from that of pixels."""


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
    first
        By the same key: what the first frames tell one by one, as far as it is known.

    """

    statistics: Mapping[SeriesKey, SeriesStatistics]
    hashes: Mapping[str, str]
    excluded: tuple[Exclusion, ...]
    findings: tuple[Finding, ...]
    sums: Mapping[SeriesKey, PixelSums] = field(default_factory=dict)
    first: Mapping[SeriesKey, FirstFrames] = field(default_factory=dict)


def reduce_study(
    study: Study,
    *,
    workers: int,
    tile: int = 64,
    progress: Progress | None = None,
    keep: Collection[Kind] = (),
    scratch: Path | None = None,
    pairs: bool = False,
    cache: SeriesCache | None = None,
    cluster: Cluster | None = None,
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
        Folder for these sums where all together take more than 200 MB; the caller's, who removes it when they are no
        longer used.
    pairs
        Whether the first two frames of each series are also looked at as a pair.
    cache
        Where finished series are looked for and kept.
    cluster
        Who reads in place of this machine's threads.

    Raises
    ------
    UsageError
        The frames are too small or too large, or the tile is; or planes have a single row or column.
    ValueError
        The sums take more than 200 MB and there is no folder for them.

    """
    series = [one for one in study.series if one.frames]
    kept = frozenset(one.key for one in series if one.kind in keep)
    layout = _layout(study, tile)
    desk = _Desk(series, layout, kept=kept, at_once=len(kept), scratch=scratch, cache=cache, pairs=pairs)
    desk.read(workers=workers, progress=progress, cluster=cluster)
    return _reduction(series, desk.outcomes)


def reduce_in_groups(
    study: Study,
    groups: Sequence[Sequence[Series]],
    *,
    workers: int,
    tile: int = 64,
    progress: Progress | None = None,
    kept: Collection[SeriesKey] = (),
    scratch: Path | None = None,
    pairs: bool = False,
    cache: SeriesCache | None = None,
    cluster: Cluster | None = None,
    meanwhile: Callable[[], None] | None = None,
) -> Generator[Reduction]:
    """Yield what each group of series comes to, while those of the next are read.

    The sums of a group are there until the next one is asked for. A caller that may give up closes the generator.

    Parameters
    ----------
    study
        Of which the series are.
    groups
        Series, in the order they are wanted; those without frames are passed over.
    workers, tile, progress, scratch, pairs, cache, cluster
        As `reduce_study`; a single worker reads no group while another is looked at.
    kept
        Series whose sums are kept pixel by pixel.
    meanwhile
        Called while frames are read, once the first series is there.

    Raises
    ------
    UsageError, ValueError
        As `reduce_study`.

    """
    every = [[one for one in group if one.frames] for group in groups]
    series, ahead = list(chain.from_iterable(every)), int(workers > 1)
    wanted = [sum(one.key in kept for one in group) for group in every]
    desk = _Desk(
        series,
        _layout(study, tile),
        kept=frozenset(kept),
        at_once=max((sum(wanted[at : at + 1 + ahead]) for at in range(len(wanted))), default=0),
        scratch=scratch,
        cache=cache,
        pairs=pairs,
    )
    desk.waits = ReadAhead([[one.key for one in group] for group in every], ahead=ahead)
    told = Stoppable(progress, desk.waits)

    def read() -> None:
        desk.read(workers=workers, progress=told, cluster=cluster)

    with closing(desk.waits.groups(read, meanwhile=meanwhile)) as places:
        for place in places:
            yield _reduction(every[place], desk.outcomes)
            desk.forget(every[place])


def _layout(study: Study, tile: int) -> Layout:
    try:
        layout = Layout(height=study.height, width=study.width, cfa=study.cfa, tile=tile)
    except ValueError as error:
        raise UsageError(str(error)) from error
    if min(layout.plane(layout.sites - 1)) < _FEWEST_LINES:
        raise UsageError(
            f"frames of {study.height} x {study.width} pixels have planes of one row or column, whose noise cannot "
            "be told apart from that of pixels; put the lines of a line camera below each other in frames of many rows"
        )
    return layout


class _Desk:
    """Where what series came to is looked up and put down."""

    def __init__(
        self,
        series: Sequence[Series],
        layout: Layout,
        *,
        kept: frozenset[SeriesKey],
        at_once: int,
        scratch: Path | None,
        cache: SeriesCache | None,
        pairs: bool,
    ) -> None:
        self._series = series
        self._layout = layout
        self._kept = kept
        self._pairs = pairs
        self._sums = KeptSums(series=at_once, pixels=layout.height * layout.width, folder=scratch)
        self._cache = cache
        known = () if cache is None else series
        self._recipes = {one.key: recipe(one, layout, sums=one.key in kept, pairs=pairs) for one in known}
        self.outcomes: dict[SeriesKey, SeriesOutcome] = {}
        self.waits: ReadAhead | None = None

    def read(self, *, workers: int, progress: Progress | None, cluster: Cluster | None) -> None:
        """Look up what is known of the series, and read the others."""
        if progress is not None:
            progress.start(sum(len(one.frames) for one in self._series))
        missing = self._look_up(workers=workers, progress=progress)
        if missing:
            how = plan(missing, self._layout, workers=workers, pairs=self._pairs, kept=self._kept)
            reduce = reduce_in_threads if cluster is None else cluster.reduce
            reduce(missing, plan=how, done=self._done, progress=progress)

    def forget(self, series: Sequence[Series]) -> None:
        """Let the sums of some series go."""
        for one in series:
            sums = self.outcomes[one.key].sums
            if sums is not None:
                self._sums.forget(sums)
            self.outcomes[one.key] = replace(self.outcomes[one.key], sums=None, first=None)

    def _look_up(self, *, workers: int, progress: Progress | None) -> list[Series]:
        """Take what is known of the series, and return those that must be read."""
        if self._cache is None:
            return list(self._series)
        recipes = [self._recipes[one.key] for one in self._series]
        for key, outcome in self._cache.find(self._series, recipes, workers=workers).items():
            self._put(key, outcome)
        if progress is not None:
            progress.advance(sum(len(one.frames) for one in self._series if one.key in self.outcomes))
        return [one for one in self._series if one.key not in self.outcomes]

    def _done(self, series: Series, outcome: SeriesOutcome) -> None:
        """Put down what a series came to; from any thread."""
        if self.waits is not None:
            self.waits.admit(series.key, self._sums.roomy)
        kept = series.key in self._kept
        sums = outcome.sums if kept else None
        narrow = None if sums is None else narrowed(sums)
        first = outcome.first if kept or outcome.first is None else replace(outcome.first, middles=None)
        outcome = replace(outcome, sums=narrow, first=first)
        cached = None if self._cache is None else self._cache.keep(series, self._recipes[series.key], outcome)
        if cached is None and narrow is not None:
            outcome = replace(outcome, sums=self._sums.keep(narrow, copied=narrow is not sums))
        self._put(series.key, cached or outcome)

    def _put(self, key: SeriesKey, outcome: SeriesOutcome) -> None:
        self.outcomes[key] = outcome
        if self.waits is not None:
            self.waits.arrived(key)


def _reduction(series: Sequence[Series], outcomes: Mapping[SeriesKey, SeriesOutcome]) -> Reduction:
    """Return what was found, in an order that depends on nothing but the study."""
    found = [(one.key, outcomes[one.key]) for one in series]
    excluded = tuple(sorted((one for _, outcome in found for one in outcome.excluded), key=lambda one: one.name))
    return Reduction(
        statistics={key: outcome.statistics for key, outcome in found if outcome.statistics is not None},
        hashes=dict(sorted(item for _, outcome in found for item in outcome.hashes.items())),
        excluded=excluded,
        findings=exclusion_findings(excluded),
        sums={key: outcome.sums for key, outcome in found if outcome.sums is not None},
        first={key: outcome.first for key, outcome in found if outcome.first is not None},
    )
