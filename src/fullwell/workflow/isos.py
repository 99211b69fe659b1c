"""One ISO after the other is measured and written out while the frames of the next one are read.

So the pixels of no more than two ISOs are in memory, however many there are, and the processors read while one thread
measures.
"""

import shutil
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from fullwell.frames.checks import exclusion_findings
from fullwell.frames.series import MEASURED_KINDS, Series, SeriesKey, Study
from fullwell.statistics.pixels import PixelSums
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.duplicates import find_copies
from fullwell.workflow.executor import Progress
from fullwell.workflow.measure.bursts import group_by_iso
from fullwell.workflow.memory import give_back
from fullwell.workflow.options import Options
from fullwell.workflow.plan import Cluster
from fullwell.workflow.reduce import Reduction, reduce_in_groups, reduce_study
from fullwell.workflow.wanted import may_be_mapped, wanted

if TYPE_CHECKING:
    from fullwell.workflow.iso_measurer import IsoMeasurer, MeasuredIsos


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoReader:
    """How the frames of a study are read and where what is made of them goes.

    Parameters
    ----------
    study
        All there is.
    options, tile
        What to measure and how; edge of a tile.
    folder
        Where maps and tables are written; None writes none, and takes no pictures.
    scratch
        Folder for sums that do not fit into memory.
    progress, cache, cluster
        As `reduce.reduce_in_groups`.

    """

    study: Study
    options: Options
    tile: int
    folder: Path | None
    scratch: Path
    progress: Progress | None = None
    cache: SeriesCache | None = None
    cluster: Cluster | None = None

    def measure(self, measured: Study) -> "MeasuredIsos":
        """Measure every ISO of a study.

        Whether a file is a copy of another is known only when all have been read. Where there are copies, which is
        rare, all is done again without them.

        Parameters
        ----------
        measured
            The study's series of flats, dark and bias frames.

        """
        found = self._pass(measured, measured.series)
        copies = find_copies(measured, found.reduction)
        if copies.there:
            for folder in () if self.folder is None else (self.folder / "maps", self.folder / "tables"):
                shutil.rmtree(folder, ignore_errors=True)
            again = self._pass(measured, copies.left_out(measured.series))
            files = replace(found.reduction, statistics=again.reduction.statistics)
            found = replace(again, reduction=files)
        return replace(found, reduction=copies.named(found.reduction))

    def _pass(self, measured: Study, series: Sequence[Series]) -> "MeasuredIsos":
        """Read some series of a study, and measure each ISO as soon as it has been read."""
        order = sorted(measured.isos, key=lambda iso: (iso is None, iso or 0.0))
        groups = [[one for one in series if one.iso == iso] for iso in order]
        kept = wanted(groups, stacks=bool(self.options.profiles))
        reductions = reduce_in_groups(
            measured,
            groups,
            workers=self.options.workers,
            tile=self.tile,
            progress=self.progress,
            kept=kept,
            scratch=self.scratch,
            pairs=bool(self.options.profiles),
            cache=self.cache,
            cluster=self.cluster,
            meanwhile=_load_measurer,
        )
        files: list[Reduction] = []
        measurer: IsoMeasurer | None = None
        with closing(reductions):
            for reduction in reductions:
                files.append(replace(reduction, sums={}, first={}))
                sums = {**reduction.sums, **self._sums_missed(measured, series, reduction, kept)}
                measurer = measurer or self._measurer()
                for bursts in group_by_iso(measured, reduction.statistics, sums, reduction.first):
                    measurer.measure(bursts)
                give_back()
        return (measurer or self._measurer()).measured(_together(measured, files), order=measured.isos)

    def _sums_missed(
        self, measured: Study, series: Sequence[Series], reduction: Reduction, kept: frozenset[SeriesKey]
    ) -> Mapping[SeriesKey, PixelSums]:
        """Read the series again that maps are made of in place of others, whose frames turned out to be damaged."""
        found = reduction.statistics
        good = [
            replace(one, frames=tuple(frame for frame in one.frames if frame.name in found[one.key].frames))
            for one in series
            if one.key in found
        ]
        missed = frozenset() if self.options.profiles else may_be_mapped(good) - kept
        if not missed:
            return {}
        again = replace(measured, series=tuple(one for one in good if one.key in missed))
        return reduce_study(
            again,
            workers=self.options.workers,
            tile=self.tile,
            keep=MEASURED_KINDS,
            scratch=self.scratch,
            cache=self.cache,
            cluster=self.cluster,
        ).sums

    def _measurer(self) -> "IsoMeasurer":
        from fullwell.workflow.iso_measurer import IsoMeasurer  # noqa: PLC0415 - loads while files are read

        return IsoMeasurer(self.study, options=self.options, folder=self.folder)


def _load_measurer() -> None:
    """Load all that measures: while files are read, a processor has nothing else to do."""
    import_module("fullwell.workflow.spanning")


def _together(study: Study, files: Sequence[Reduction]) -> Reduction:
    """Return what all groups came to, in an order that depends on nothing but the study."""
    statistics = {key: one for each in files for key, one in each.statistics.items()}
    excluded = tuple(sorted(chain.from_iterable(one.excluded for one in files), key=lambda one: one.name))
    hashes: Mapping[str, str] = {name: one for each in files for name, one in each.hashes.items()}
    return Reduction(
        statistics={one.key: statistics[one.key] for one in study.series if one.key in statistics},
        hashes=dict(sorted(hashes.items())),
        excluded=excluded,
        findings=exclusion_findings(excluded),
    )
