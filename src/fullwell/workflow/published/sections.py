"""What the published study would have said, as rows and curves beside the recommended ones."""

from collections.abc import Iterable, Mapping

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.fit.legacy.response import StudyResponse, response_figures
from fullwell.fit.legacy.shading_map import Poly22, evaluate
from fullwell.fit.legacy.std_line import StdLine
from fullwell.fit.legacy.volts import VoltScale
from fullwell.frames.series import SeriesKey
from fullwell.raw.cfa import ALL
from fullwell.units import DN, ONE, VOLT, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.iso import IsoMeasurement
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.shading import ChannelShading
from fullwell.workflow.published.second_look import SecondLook


def response_section(group: IsoBursts, response: StudyResponse) -> Section:
    """Return the study's PRNU and DSNU of one ISO, and its PRNU by tile."""
    return Section(rows=tuple(_response_rows(group, response)), curves=(_tiles(group, response),))


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


def _tiles(group: IsoBursts, response: StudyResponse) -> Curve:
    """Return the study's PRNU in its own sixteen tiles."""
    tiles, channels = response.regions.tiles, response.channels
    places = [(index, channel, tile) for index, channel in enumerate(channels) for tile in tiles]
    percent = response.tile_spread.prnu_percent
    return Curve(
        name="prnu_tiles_legacy",
        columns=(
            Column(name="iso", unit="1", values=(group.iso,) * len(places)),
            Column(name="channel", unit="", values=tuple(channel for _, channel, _ in places)),
            Column(name="x", unit="pixel", values=tuple(tile.left for _, _, tile in places)),
            Column(name="y", unit="pixel", values=tuple(tile.top for _, _, tile in places)),
            Column(name="width", unit="pixel", values=tuple(tile.width for _, _, tile in places)),
            Column(name="height", unit="pixel", values=tuple(tile.height for _, _, tile in places)),
            Column(name="prnu", unit="%", values=tuple(percent.T.ravel().tolist())),
        ),
    )


def shading_section(measured: IsoMeasurement, surfaces: Mapping[tuple[SeriesKey, str], Poly22]) -> Section:
    """Return corner, edges and residual of the study's surfaces of one ISO, pedestal left in.

    Parameters
    ----------
    measured
        What was measured at that ISO.
    surfaces
        By the key of the series and channel.

    """
    flats = [(burst, channel) for burst in measured.bursts.flats for channel in measured.bursts.channels]
    known = [(*one, surface) for one in flats if (surface := surfaces.get((one[0].series.key, one[1]))) is not None]
    return Section(rows=tuple(_shading_rows(measured, known)))


def _shading_rows(measured: IsoMeasurement, surfaces: Iterable[tuple[Burst, str, Poly22]]) -> Iterable[Row]:
    write = RowWriter(bursts=measured.bursts).row
    own = {(one.burst.series.key, channel.channel): channel for one in measured.shadings for channel in one.channels}
    for burst, channel, surface in surfaces:
        rows, columns = float(surface.rows), float(surface.columns)
        middle = ((rows + 1.0) / 2.0, (columns + 1.0) / 2.0)
        figures = {
            "shading_corner": _relative(surface, (1.0, rows), (1.0, columns)),
            "shading_edge_x": _relative(surface, (middle[0],), (1.0, columns)),
            "shading_edge_y": _relative(surface, (1.0, rows), (middle[1],)),
        }
        fitted = own.get((burst.series.key, channel))
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


def look_section(look: SecondLook, base: IsoBursts | None, volts: VoltScale | None) -> Section:
    """Return what single frames said: read noise per repeat, and the line of the lowest ISO's flats.

    Parameters
    ----------
    look
        What they said.
    base
        The bursts of the lowest ISO that has flats.
    volts
        None where the voltage swing is unknown.

    """
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
    if look.std_line is not None and base is not None:
        curves.append(_std_curve(base, look.std_line))
        rows = tuple(_std_rows(base, look.std_line, volts))
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


def _std_rows(group: IsoBursts, line: StdLine, volts: VoltScale | None) -> Iterable[Row]:
    channel = group.channels[0] if len(group.channels) == 1 else ALL
    write = RowWriter(bursts=group).row
    n = sum(plane.n * burst.frames for burst in group.flats for plane in burst.statistics.planes)
    values = [(line.intercept_dn, DN, "PIXEL4A DSNU")]
    if volts is not None:
        values.append((volts.level_v(line.as_published), VOLT, "PIXEL4A DSNU, as published: im2double taken for DN"))
    for value, unit, source in values:
        yield write("dsnu", channel, "legacy-std-intercept", Measured.exact(value, unit), source=source, n=n)
