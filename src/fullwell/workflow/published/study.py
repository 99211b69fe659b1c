"""The published Pixel study's own figures and tables, beside the recommended ones (METHOD 3.2, 5.3; RESULTS 4)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from fullwell.fit.legacy.dark import DarkFrames, StudyDarkLine, study_dark_lines
from fullwell.fit.legacy.regions import StudyRegions, study_regions
from fullwell.fit.legacy.response import StudyResponse, study_response
from fullwell.fit.legacy.shading_map import LegacyMap, Poly22, fit_legacy_map
from fullwell.fit.legacy.volts import VoltScale
from fullwell.frames.series import SeriesKey, Study
from fullwell.report.study_tables import ShadingCoefficients, StudyTables, write_iso_tables, write_study_tables
from fullwell.workflow.executor import Progress, in_threads
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.iso import IsoMeasurement
from fullwell.workflow.measure.section import Section, joined
from fullwell.workflow.options import Options
from fullwell.workflow.published.second_look import base_group, look_again
from fullwell.workflow.published.sections import look_section, response_section, shading_section

_SMALLEST: Final = 6
"""Side of a mosaic whose planes hold a quadratic surface [pixel]."""
Surfaces = Mapping[tuple[SeriesKey, str], Poly22]
"""By the key of the series and channel."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedStudy:
    """What the study would have said, and its quadratic surfaces by the key of the series and channel."""

    section: Section
    surfaces: Surfaces


@dataclass(frozen=True, slots=True, kw_only=True)
class _Base:
    """The one map that the study divides every flat by, and where it looks."""

    iso: float | None
    exposure_s: float
    black_dn: tuple[float, ...] | None
    map: LegacyMap
    regions: StudyRegions


@dataclass(frozen=True, slots=True, kw_only=True)
class _Measured:
    """What was found at one ISO."""

    iso: float | None
    section: Section
    surfaces: Surfaces


class PublishedMeasurement:
    """The study's figures, made ISO by ISO: its tables of pixels are written before the next ISO's sums are read.

    Parameters
    ----------
    study
        Its frames and facts.
    options
        Workers, and whether black is subtracted first.
    folder
        Where ``tables/`` is written; None writes none.

    """

    def __init__(self, study: Study, *, options: Options, folder: Path | None) -> None:
        self._study = study
        self._options = options
        self._tables = None if folder is None else folder / "tables"
        self._measured: list[_Measured] = []
        self._maps: dict[SeriesKey, LegacyMap] = {}
        self._lit = False
        self._base: _Base | None = None

    def add(self, one: IsoMeasurement) -> None:
        """Take what was measured at an ISO while the sums of its bursts are there; the lowest ISO comes first."""
        workers = self._options.workers
        black = tuple(level.black_dn for level in one.levels) if self._options.legacy_black_subtracted else None
        self._maps |= _maps(self._study, one.bursts, black, workers=workers)
        if one.bursts.flats and not self._lit:
            self._lit, self._base = True, _base(self._study, one.bursts, self._maps, black)
        surfaces = _surfaces(one.bursts, self._maps)
        sections = [shading_section(one, surfaces)]
        response = _response(self._study, one.bursts, self._base, black)
        if response is not None:
            sections.append(response_section(one.bursts, response))
            if self._tables is not None:
                write_iso_tables(response, self._tables, workers=workers)
        self._measured.append(_Measured(iso=one.bursts.iso, section=joined(sections), surfaces=surfaces))

    def finish(self, groups: Sequence[IsoBursts], *, progress: Progress | None = None) -> PublishedStudy:
        """Look again at single frames and write what spans the study.

        Parameters
        ----------
        groups
            The bursts of every ISO, in the order of the results.
        progress
            Told of every frame that is read a second time.

        """
        base, volts = self._base, _volts(self._study)
        look = look_again(
            groups,
            base=None if base is None else base.map,
            workers=self._options.workers,
            black_dn=None if base is None else base.black_dn,
            progress=progress,
        )
        if self._tables is not None:
            spanning = StudyTables(
                coefficients=tuple(_coefficients(groups, self._maps)),
                read_noise=look.read_noise,
                dark_lines=tuple(_dark_lines(self._study, groups)),
                volts=volts,
                base_iso=None if base is None else base.iso,
                base_exposure_s=None if base is None else base.exposure_s,
                scaled=base is not None and base.regions.scaled,
                black_subtracted=bool(groups) and self._options.legacy_black_subtracted,
            )
            write_study_tables(spanning, self._tables)
        of_isos = {one.iso: one.section for one in self._measured}
        sections = [look_section(look, base_group(groups), volts), *(of_isos[group.iso] for group in groups)]
        surfaces = {key: surface for one in self._measured for key, surface in one.surfaces.items()}
        return PublishedStudy(section=joined(sections), surfaces=surfaces)


def _maps(
    study: Study, group: IsoBursts, black: tuple[float, ...] | None, *, workers: int
) -> dict[SeriesKey, LegacyMap]:
    """Return the map of every flat burst of an ISO by the key of its series."""
    if min(study.width, study.height) < _SMALLEST:
        return {}

    def fit(burst: Burst) -> LegacyMap | None:
        if burst.sums is None:
            return None
        return fit_legacy_map(burst.sums, burst.frames, cfa=study.cfa, black_dn=black)

    fitted = in_threads(fit, group.flats, workers=workers)
    return {burst.series.key: one for burst, one in zip(group.flats, fitted, strict=True) if one is not None}


def _surfaces(group: IsoBursts, maps: Mapping[SeriesKey, LegacyMap]) -> Surfaces:
    return {
        (burst.series.key, channel): surface
        for burst, fitted in _fitted(group, maps)
        for channel, surface in zip(group.channels, fitted.surfaces, strict=True)
    }


def _fitted(group: IsoBursts, maps: Mapping[SeriesKey, LegacyMap]) -> Iterable[tuple[Burst, LegacyMap]]:
    for burst in group.flats:
        if burst.series.key in maps:
            yield burst, maps[burst.series.key]


def _coefficients(groups: Sequence[IsoBursts], maps: Mapping[SeriesKey, LegacyMap]) -> Iterable[ShadingCoefficients]:
    for group in groups:
        for burst, fitted in _fitted(group, maps):
            for channel, surface in zip(group.channels, fitted.surfaces, strict=True):
                yield ShadingCoefficients(iso=group.iso, exposure_s=burst.exposure_s, channel=channel, surface=surface)


def _base(
    study: Study, group: IsoBursts, maps: Mapping[SeriesKey, LegacyMap], black: tuple[float, ...] | None
) -> _Base | None:
    burst = group.flats[0]
    if burst.series.key not in maps:
        return None
    return _Base(
        iso=group.iso,
        exposure_s=burst.exposure_s,
        black_dn=black,
        map=maps[burst.series.key],
        regions=study_regions(study.height, study.width),
    )


def _response(
    study: Study, group: IsoBursts, base: _Base | None, black: tuple[float, ...] | None
) -> StudyResponse | None:
    flats = [burst for burst in group.flats if burst.sums is not None]
    if base is None or len({burst.exposure_s for burst in flats}) < 2:
        return None
    return study_response(
        [burst.sums for burst in flats if burst.sums is not None],
        [burst.frames for burst in flats],
        [burst.exposure_s for burst in flats],
        iso=group.iso,
        cfa=study.cfa,
        base=base.map,
        regions=base.regions,
        black_dn=black,
    )


def _volts(study: Study) -> VoltScale | None:
    swing = study.camera.voltage_swing_v
    if swing is None or study.white_level is None:
        return None
    return VoltScale(swing_v=swing, bit_depth=study.bit_depth, white_level=min(study.white_level.values))


def _dark_lines(study: Study, groups: Sequence[IsoBursts]) -> Iterable[StudyDarkLine]:
    dark = [group for group in groups if len({burst.exposure_s for burst in group.darks}) > 1]
    lowest = min((group.iso or 0.0 for group in dark), default=0.0)
    for group in dark:
        bursts = [_dark_frames(burst) for burst in group.darks]
        yield from study_dark_lines(bursts, iso=group.iso, cfa=study.cfa, every_frame=(group.iso or 0.0) == lowest)


def _dark_frames(burst: Burst) -> DarkFrames:
    planes = burst.statistics.planes
    by_name = {frame.name: frame.header.exposure_s for frame in burst.series.frames}
    exposures = [by_name.get(name) for name in burst.statistics.frames]
    return DarkFrames(
        exposures_s=np.array([burst.exposure_s if one is None else one for one in exposures]),
        frame_means_dn=np.stack([plane.frame_means for plane in planes], axis=1),
        pixels=np.array([plane.n for plane in planes]),
    )
