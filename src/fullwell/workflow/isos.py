"""One ISO after the other is measured and written out while the frames of the next one are read.

So the pixels of no more than two ISOs are in memory, however many there are, and the processors read while one thread
measures.
"""

import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from fullwell.frames.checks import exclusion_findings
from fullwell.frames.series import MEASURED_KINDS, Series, SeriesKey, Study
from fullwell.report.pictures import Pictures, ResponsePicture
from fullwell.statistics.pixels import PixelSums
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.duplicates import find_copies
from fullwell.workflow.executor import Progress
from fullwell.workflow.iso_maps import write_response_maps, write_shading_maps
from fullwell.workflow.measure.bursts import IsoBursts, group_by_iso, without_pixels
from fullwell.workflow.measure.emva.stacks import FEWEST_FRAMES
from fullwell.workflow.measure.iso import IsoMeasurement, measure_iso, without_sums
from fullwell.workflow.measure.pattern_maps import IsoMaps, may_be_mapped
from fullwell.workflow.measure.section import Section
from fullwell.workflow.measure.temperatures import measure_temperatures
from fullwell.workflow.memory import give_back
from fullwell.workflow.options import Options
from fullwell.workflow.pattern_pictures import response_pictures
from fullwell.workflow.pictures import take_pictures
from fullwell.workflow.plan import Cluster
from fullwell.workflow.published.study import PublishedMeasurement
from fullwell.workflow.reduce import Reduction, reduce_in_groups, reduce_study


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoOutcome:
    """What one ISO came to, without its pixels.

    Parameters
    ----------
    bursts
        All that was taken.
    measured
        What was measured at its main temperature.
    temperatures
        What was measured at others.
    pictures
        Of two unlit frames, at the first ISO that has such.
    responses
        Of the slopes of its pixels.

    """

    bursts: IsoBursts
    measured: IsoMeasurement
    temperatures: Section
    pictures: Pictures
    responses: tuple[ResponsePicture, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredIsos:
    """Every ISO of a study, in ascending order; what its files came to; and the published study's figures so far."""

    isos: tuple[IsoOutcome, ...]
    reduction: Reduction
    published: PublishedMeasurement


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

    def measure(self, measured: Study) -> MeasuredIsos:
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

    def _pass(self, measured: Study, series: Sequence[Series]) -> MeasuredIsos:
        """Read some series of a study, and measure each ISO as soon as it has been read."""
        published = PublishedMeasurement(self.study, options=self.options, folder=self.folder)
        order = sorted(measured.isos, key=lambda iso: (iso is None, iso or 0.0))
        groups = [[one for one in series if one.iso == iso] for iso in order]
        kept = self._kept(groups)
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
        )
        files: list[Reduction] = []
        isos: list[IsoOutcome] = []
        with closing(reductions):
            for reduction in reductions:
                files.append(replace(reduction, sums={}, first={}))
                sums = {**reduction.sums, **self._sums_missed(measured, series, reduction, kept)}
                found = group_by_iso(measured, reduction.statistics, sums, reduction.first)
                isos.extend(self._measured(bursts, published, isos) for bursts in found)
                give_back()
        isos.sort(key=lambda one: measured.isos.index(one.bursts.iso))
        return MeasuredIsos(isos=tuple(isos), reduction=_together(measured, files), published=published)

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

    def _kept(self, groups: Iterable[Sequence[Series]]) -> frozenset[SeriesKey]:
        """Return the series whose pixels are looked at one by one."""
        if self.options.profiles:
            return frozenset(one.key for one in chain(*groups) if len(one.frames) >= FEWEST_FRAMES)
        return frozenset(key for group in groups for key in may_be_mapped(group))

    def _measured(self, bursts: IsoBursts, published: PublishedMeasurement, before: Iterable[IsoOutcome]) -> IsoOutcome:
        """Measure an ISO while its sums are there."""
        profiles = self.options.profiles
        responses: list[ResponsePicture] = []

        def maps_made(used: IsoBursts, maps: IsoMaps) -> None:
            if self.folder is not None:
                write_response_maps(self.study, used, maps, self.folder / "maps")
                responses.extend(response_pictures(self.study, used.iso, maps))

        one = measure_iso(self.study, bursts, workers=self.options.workers, profiles=profiles, maps_made=maps_made)
        pictures = Pictures()
        if self.folder is not None:
            write_shading_maps(self.study, one, self.folder / "maps")
            pictures = pictures if any(iso.pictures.differences for iso in before) else take_pictures(bursts)
        published.add(one)
        return IsoOutcome(
            bursts=without_pixels(bursts),
            measured=without_sums(one),
            temperatures=measure_temperatures(self.study, bursts, one.section.rows, profiles=profiles),
            pictures=pictures,
            responses=tuple(responses),
        )


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
