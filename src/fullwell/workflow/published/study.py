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
from fullwell.workflow.scratch import let_go

_SMALLEST: Final = 6
"""Side of a mosaic whose planes hold a quadratic surface [pixel]."""
_Black = Mapping[float | None, tuple[float, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedStudy:
    """What the study would have said, and its quadratic surfaces by the key of the series and channel."""

    section: Section
    surfaces: Mapping[tuple[SeriesKey, str], Poly22]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Base:
    """The one map that the study divides every flat by, and where it looks."""

    group: IsoBursts
    burst: Burst
    map: LegacyMap
    regions: StudyRegions


def measure_published_study(
    study: Study,
    measured: Sequence[IsoMeasurement],
    *,
    options: Options,
    folder: Path | None,
    progress: Progress | None = None,
) -> PublishedStudy:
    """Return the study's figures; write its tables below ``folder`` unless that is None.

    Parameters
    ----------
    study
        Its frames and facts.
    measured
        Every ISO.
    options
        Workers, and whether black is subtracted first.
    folder
        Where ``tables/`` is written.
    progress
        Told of every frame that is read a second time.

    """
    black = _black(measured) if options.legacy_black_subtracted else {}
    groups = [one.bursts for one in measured]
    maps = _maps(study, groups, black, workers=options.workers)
    surfaces = {
        (burst.series.key, channel): surface
        for group, burst, fitted in _fitted(groups, maps)
        for channel, surface in zip(group.channels, fitted.surfaces, strict=True)
    }
    base = _base(study, groups, maps)
    tables = None if folder is None else folder / "tables"
    look = look_again(
        groups,
        base=None if base is None else base.map,
        workers=options.workers,
        black_dn=None if base is None else black.get(base.group.iso),
        progress=progress,
    )
    volts = _volts(study)
    sections = [look_section(look, base_group(groups), volts)]
    for one in measured:
        sections.append(shading_section(one, surfaces))
        response = _response(study, one.bursts, base, black.get(one.bursts.iso))
        if response is not None:
            sections.append(response_section(one.bursts, response))
            if tables is not None:
                write_iso_tables(response, tables, workers=options.workers)
    if tables is not None:
        spanning = StudyTables(
            coefficients=tuple(_coefficients(groups, maps)),
            read_noise=look.read_noise,
            dark_lines=tuple(_dark_lines(study, groups)),
            volts=volts,
            base_iso=None if base is None else base.group.iso,
            base_exposure_s=None if base is None else base.burst.exposure_s,
            scaled=base is not None and base.regions.scaled,
            black_subtracted=bool(black),
        )
        write_study_tables(spanning, tables)
    return PublishedStudy(section=joined(sections), surfaces=surfaces)


def _black(measured: Sequence[IsoMeasurement]) -> _Black:
    """Return the black level of every CFA site by ISO [DN]."""
    return {one.bursts.iso: tuple(level.black_dn for level in one.levels) for one in measured}


def _maps(study: Study, groups: Sequence[IsoBursts], black: _Black, *, workers: int) -> Mapping[SeriesKey, LegacyMap]:
    """Return the map of every flat burst by the key of its series."""
    if min(study.width, study.height) < _SMALLEST:
        return {}
    flats = [(group.iso, burst) for group in groups for burst in group.flats]

    def fit(one: tuple[float | None, Burst]) -> LegacyMap | None:
        iso, burst = one
        if burst.sums is None:
            return None
        fitted = fit_legacy_map(burst.sums, burst.frames, cfa=study.cfa, black_dn=black.get(iso))
        let_go(burst.sums)
        return fitted

    fitted = in_threads(fit, flats, workers=workers)
    return {burst.series.key: one for (_, burst), one in zip(flats, fitted, strict=True) if one is not None}


def _fitted(
    groups: Sequence[IsoBursts], maps: Mapping[SeriesKey, LegacyMap]
) -> Iterable[tuple[IsoBursts, Burst, LegacyMap]]:
    for group in groups:
        for burst in group.flats:
            if burst.series.key in maps:
                yield group, burst, maps[burst.series.key]


def _coefficients(groups: Sequence[IsoBursts], maps: Mapping[SeriesKey, LegacyMap]) -> Iterable[ShadingCoefficients]:
    for group, burst, fitted in _fitted(groups, maps):
        for channel, surface in zip(group.channels, fitted.surfaces, strict=True):
            yield ShadingCoefficients(iso=group.iso, exposure_s=burst.exposure_s, channel=channel, surface=surface)


def _base(study: Study, groups: Sequence[IsoBursts], maps: Mapping[SeriesKey, LegacyMap]) -> _Base | None:
    group = base_group(groups)
    if group is None or group.flats[0].series.key not in maps:
        return None
    burst = group.flats[0]
    return _Base(group=group, burst=burst, map=maps[burst.series.key], regions=study_regions(study.height, study.width))


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
