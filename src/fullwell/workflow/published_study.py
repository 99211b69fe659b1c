"""The published Pixel study's own figures and tables, beside the recommended ones (METHOD 3.2, 5.3; RESULTS 4)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.fit.legacy.dark import DarkFrames, StudyDarkLine, study_dark_lines
from fullwell.fit.legacy.regions import StudyRegions, study_regions
from fullwell.fit.legacy.response import StudyResponse, response_figures, study_response
from fullwell.fit.legacy.shading_map import LegacyMap, Poly22, evaluate, fit_legacy_map
from fullwell.fit.legacy.std_line import StdLine
from fullwell.fit.legacy.volts import VoltScale
from fullwell.frames.series import Study
from fullwell.raw.cfa import ALL
from fullwell.report.study_tables import ShadingCoefficients, StudyTables, write_iso_tables, write_study_tables
from fullwell.units import DN, ONE, VOLT, Measured
from fullwell.workflow.executor import Progress
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.iso import IsoMeasurement
from fullwell.workflow.measure.section import RowWriter, Section, joined
from fullwell.workflow.measure.shading import ChannelShading
from fullwell.workflow.options import Options
from fullwell.workflow.second_look import SecondLook, base_group, look_again


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedStudy:
    """What the study would have said, and its quadratic surfaces by identity of the burst and channel."""

    section: Section
    surfaces: Mapping[tuple[int, str], Poly22]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Base:
    """The one map that the study divides every flat by, and where it looks."""

    group: IsoBursts
    burst: Burst
    map: LegacyMap
    regions: StudyRegions | None


def measure_published_study(
    study: Study,
    measured: Sequence[IsoMeasurement],
    *,
    options: Options,
    folder: Path | None,
    progress: Progress | None = None,
) -> PublishedStudy:
    """Return the study's figures; write its tables below ``folder`` unless that is None."""
    black = _black(measured) if options.legacy_black_subtracted else {}
    groups = [one.bursts for one in measured]
    base = _base(study, groups, black)
    tables = None if folder is None else folder / "tables"
    look = look_again(
        groups,
        base=None if base is None else base.map,
        workers=options.workers,
        black_dn=None if base is None else black.get(base.group.iso),
        progress=progress,
    )
    sections = [_look_section(study, look, groups)]
    coefficients: list[ShadingCoefficients] = []
    every: dict[tuple[int, str], Poly22] = {}
    for one in measured:
        surfaces = _surfaces(study, one.bursts, black.get(one.bursts.iso))
        coefficients += [
            ShadingCoefficients(iso=one.bursts.iso, exposure_s=burst.exposure_s, channel=channel, surface=surface)
            for burst, channel, surface in surfaces
        ]
        every |= {(id(burst), channel): surface for burst, channel, surface in surfaces}
        sections.append(Section(rows=tuple(_shading_rows(one, surfaces))))
        response = _response(study, one.bursts, base, black.get(one.bursts.iso))
        if response is None:
            continue
        sections.append(Section(rows=tuple(_response_rows(one.bursts, response)), curves=(_tiles(one, response),)))
        if tables is not None:
            write_iso_tables(response, tables, workers=options.workers)
    if tables is not None:
        spanning = _study_tables(study, groups, base, look, coefficients)
        write_study_tables(replace(spanning, black_subtracted=bool(black)), tables)
    return PublishedStudy(section=joined(sections), surfaces=every)


def _black(measured: Sequence[IsoMeasurement]) -> Mapping[float | None, tuple[float, ...]]:
    """Return the black level of every CFA site by ISO [DN]."""
    return {one.bursts.iso: tuple(level.black_dn for level in one.levels) for one in measured}


def _base(study: Study, groups: Sequence[IsoBursts], black: Mapping[float | None, tuple[float, ...]]) -> _Base | None:
    group = base_group(groups)
    if group is None or group.flats[0].sums is None:
        return None
    burst = group.flats[0]
    if burst.sums is None or min(study.width, study.height) < 6:
        return None
    return _Base(
        group=group,
        burst=burst,
        map=fit_legacy_map(burst.sums, burst.frames, cfa=study.cfa, black_dn=black.get(group.iso)),
        regions=study_regions(study.height, study.width),
    )


def _response(
    study: Study, group: IsoBursts, base: _Base | None, black: tuple[float, ...] | None
) -> StudyResponse | None:
    flats = [burst for burst in group.flats if burst.sums is not None]
    if base is None or base.regions is None or len({burst.exposure_s for burst in flats}) < 2:
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


def _response_rows(group: IsoBursts, response: StudyResponse) -> Iterable[Row]:
    write = RowWriter(bursts=group).row
    for one in response_figures(response):
        yield write(
            one.quantity,
            one.channel,
            one.method,
            Measured.exact(one.value, one.unit),
            source="PIXEL4A PRNU, DSNU",
            n=one.n,
            region=one.region,
            flags=one.flags,
        )


def _tiles(measured: IsoMeasurement, response: StudyResponse) -> Curve:
    """Return the study's PRNU in its own sixteen tiles."""
    tiles, channels = response.regions.tiles, response.channels
    places = [(index, channel, tile) for index, channel in enumerate(channels) for tile in tiles]
    percent = response.tile_spread.prnu_percent
    return Curve(
        name="prnu_tiles_legacy",
        columns=(
            Column(name="iso", unit="1", values=(measured.bursts.iso,) * len(places)),
            Column(name="channel", unit="", values=tuple(channel for _, channel, _ in places)),
            Column(name="x", unit="pixel", values=tuple(tile.left for _, _, tile in places)),
            Column(name="y", unit="pixel", values=tuple(tile.top for _, _, tile in places)),
            Column(name="width", unit="pixel", values=tuple(tile.width for _, _, tile in places)),
            Column(name="height", unit="pixel", values=tuple(tile.height for _, _, tile in places)),
            Column(name="prnu", unit="%", values=tuple(percent.T.ravel().tolist())),
        ),
    )


def _surfaces(study: Study, group: IsoBursts, black: tuple[float, ...] | None) -> tuple[tuple[Burst, str, Poly22], ...]:
    """Return the quadratic surface of every plane of every flat burst."""
    found: list[tuple[Burst, str, Poly22]] = []
    for burst in group.flats:
        if burst.sums is None or min(study.width, study.height) < 6:
            continue
        fitted = fit_legacy_map(burst.sums, burst.frames, cfa=study.cfa, black_dn=black)
        found += [(burst, channel, surface) for channel, surface in zip(group.channels, fitted.surfaces, strict=True)]
    return tuple(found)


def _shading_rows(measured: IsoMeasurement, surfaces: Sequence[tuple[Burst, str, Poly22]]) -> Iterable[Row]:
    """Return corner, edges and residual of the study's surfaces, pedestal left in."""
    write = RowWriter(bursts=measured.bursts).row
    own = {id(one.burst): one for one in measured.shadings}
    for burst, channel, surface in surfaces:
        rows, columns = float(surface.rows), float(surface.columns)
        middle = ((rows + 1.0) / 2.0, (columns + 1.0) / 2.0)
        figures = {
            "shading_corner": _relative(surface, (1.0, rows), (1.0, columns)),
            "shading_edge_x": _relative(surface, (middle[0],), (1.0, columns)),
            "shading_edge_y": _relative(surface, (1.0, rows), (middle[1],)),
        }
        shading = own.get(id(burst))
        fitted = None if shading is None else next((one for one in shading.channels if one.channel == channel), None)
        if fitted is not None:
            figures["shading_residual_rms"] = _residual(fitted, surface)
        for quantity, value in figures.items():
            yield write(
                quantity,
                channel,
                "legacy-poly22",
                Measured.exact(value, ONE),
                source="PIXEL4A shading",
                n=burst.plane(channel).n * burst.frames,
                exposure_s=burst.exposure_s,
            )


def _relative(surface: Poly22, rows: tuple[float, ...], columns: tuple[float, ...]) -> float:
    values = evaluate(surface.coefficients, np.array(rows), np.array(columns))
    return float(values.mean()) / surface.maximum


def _residual(one: ChannelShading, surface: Poly22) -> float:
    """Return the rms of measured over fitted less 1 of the bins, the pedestal in both."""
    fitted = evaluate(surface.coefficients, one.data.rows + 1.0, one.data.columns + 1.0)
    residual = (one.data.signal_dn + one.black_dn) / fitted - 1.0
    return float(np.sqrt(np.nanmean(residual**2)))


def _look_section(study: Study, look: SecondLook, groups: Sequence[IsoBursts]) -> Section:
    curves: list[Curve] = []
    repeats = [(burst, index) for burst in look.read_noise for index in range(len(burst.frames))]
    if repeats:
        curves.append(
            Curve(
                name="read_noise_repeats",
                columns=(
                    Column(name="iso", unit="1", values=tuple(burst.iso for burst, _ in repeats)),
                    Column(name="repeat", unit="1", values=tuple(index + 1 for _, index in repeats)),
                    Column(name="flow1", unit=DN, values=tuple(float(b.flow1_dn[index]) for b, index in repeats)),
                    Column(name="flow2", unit=DN, values=tuple(float(b.flow2_dn[index]) for b, index in repeats)),
                ),
            )
        )
    rows: tuple[Row, ...] = ()
    base = base_group(groups)
    if look.std_line is not None and base is not None:
        curves.append(_std_curve(base, look.std_line))
        rows = tuple(_std_rows(study, base, look.std_line))
    return Section(rows=rows, curves=tuple(curves), findings=look.findings)


def _std_curve(group: IsoBursts, line: StdLine) -> Curve:
    count = line.exposure_s.size
    fitted = line.intercept_dn + line.slope_dn_per_s * line.exposure_s
    return Curve(
        name="std_exposure",
        columns=(
            Column(name="iso", unit="1", values=(group.iso,) * count),
            Column(name="exposure_s", unit="s", values=tuple(line.exposure_s.tolist())),
            Column(name="std", unit=DN, values=tuple(line.std_dn.tolist())),
            Column(name="fitted", unit=DN, values=tuple(fitted.tolist())),
        ),
    )


def _std_rows(study: Study, group: IsoBursts, line: StdLine) -> Iterable[Row]:
    channel = group.channels[0] if len(group.channels) == 1 else ALL
    write = RowWriter(bursts=group).row
    n = sum(plane.n * burst.frames for burst in group.flats for plane in burst.statistics.planes)
    values = [(line.intercept_dn, DN, "PIXEL4A DSNU")]
    volts = _volts(study)
    if volts is not None:
        values.append((volts.level_v(line.as_published), VOLT, "PIXEL4A DSNU, as published: im2double taken for DN"))
    for value, unit, source in values:
        yield write("dsnu", channel, "legacy-std-intercept", Measured.exact(value, unit), source=source, n=n)


def _volts(study: Study) -> VoltScale | None:
    swing = study.camera.voltage_swing_v
    if swing is None or study.white_level is None:
        return None
    return VoltScale(swing_v=swing, bit_depth=study.bit_depth, white_level=min(study.white_level.values))


def _study_tables(
    study: Study,
    groups: Sequence[IsoBursts],
    base: _Base | None,
    look: SecondLook,
    coefficients: Sequence[ShadingCoefficients],
) -> StudyTables:
    return StudyTables(
        coefficients=tuple(coefficients),
        read_noise=look.read_noise,
        dark_lines=tuple(_dark_lines(study, groups)),
        volts=_volts(study),
        base_iso=None if base is None else base.group.iso,
        base_exposure_s=None if base is None else base.burst.exposure_s,
        scaled=base is not None and base.regions is not None and base.regions.scaled,
    )


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
