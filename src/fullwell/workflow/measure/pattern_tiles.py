"""DSNU and PRNU in sixteen tiles of the central crop, pooled as variances (METHOD 5.5)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.constancy import Constancy, constancy
from fullwell.fit.noise_floor import NoiseFloor
from fullwell.fit.nonuniformity import nonuniformity
from fullwell.fit.pooling import SIGNIFICANCE, equal_mean
from fullwell.statistics.pattern import pattern
from fullwell.units import PERCENT, Measured, square_root
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.nonuniformity import DSNU_FIGURE, PRNU_FIGURES, MapFigure
from fullwell.workflow.measure.pattern_maps import ChannelMaps, IsoMaps, floor_of
from fullwell.workflow.measure.regions import Region, central_crop, central_tiles
from fullwell.workflow.measure.section import RowWriter, Section

SMALLEST_EDGE = 8


FoundInTiles = Mapping[tuple[str, str], tuple[Measured, ...] | None]
"""The variances of the sixteen tiles of each map that was looked at, by channel and name of the map."""


def look_at_tiles(maps: IsoMaps, *, cell: int, width: int, height: int) -> FoundInTiles:
    """Return the variances of the tiles of the maps that are there; nothing where tiles are too small.

    Parameters
    ----------
    maps
        Of one ISO.
    cell
        Period of the mosaic [pixel].
    width, height
        Of the visible mosaic [pixel].

    """
    regions = central_tiles(width=width, height=height)
    if regions[0].width // cell < SMALLEST_EDGE:
        return {}
    return {
        (one.channel, figure.map_name): _variances(one, figure, regions, cell)
        for one in maps.channels
        for figure in _figures(one)
        if figure.map_name in one.maps
    }


def measure_pattern_tiles(bursts: IsoBursts, maps: IsoMaps, seen: FoundInTiles, *, width: int, height: int) -> Section:
    """Measure DSNU and PRNU of every channel in each of the sixteen tiles, and pool them.

    Parameters
    ----------
    bursts, maps
        Of one ISO; the maps themselves may be gone.
    seen
        What `look_at_tiles` found in all of them.
    width, height
        Of the visible mosaic [pixel].

    """
    regions = central_tiles(width=width, height=height)
    crop = central_crop(width=width, height=height)
    rows: list[Row] = []
    curves: list[Curve] = []
    uneven: list[str] = []
    for one in maps.channels:
        for figure in _figures(one):
            variances = seen.get((one.channel, figure.map_name))
            if variances is None:
                continue
            same = constancy(variances)
            rows += _rows(bursts, one.channel, figure, regions, variances, crop=crop)
            if figure.relative:
                curves.append(_curve(bursts, one.channel, regions, variances))
            if same.p_value < SIGNIFICANCE / len(maps.channels):
                uneven.append(_told(one.channel, figure, same))
    return Section(rows=tuple(rows), curves=tuple(curves), findings=_findings(bursts, uneven))


def _figures(maps: ChannelMaps) -> tuple[MapFigure, ...]:
    """Return the better figure of PRNU and that of DSNU, as far as their maps can be made."""
    known = [figure for figure in (*PRNU_FIGURES, DSNU_FIGURE) if figure.map_name in maps.combinations]
    return (*[figure for figure in known if figure.relative][:1], *[one for one in known if not one.relative])


def _variances(
    maps: ChannelMaps, figure: MapFigure, regions: Sequence[Region], cell: int
) -> tuple[Measured, ...] | None:
    """Return the signed variance of every tile in the squared unit it is shown in; None where one shows no light."""
    floor = floor_of(maps.combinations[figure.map_name], maps.channel)
    found: list[Measured] = []
    for region in regions:
        piece = maps.maps[figure.map_name][region.plane(cell)]
        own = pattern(piece, tile=max(piece.shape), relative=figure.relative)
        try:
            here = nonuniformity(own, _local(floor, maps.tile * cell, region), unit=figure.variance_unit)
        except ValueError:
            return None
        found.append(figure.shown(here.total))
    return tuple(found)


def _local(floor: NoiseFloor, tile: int, region: Region) -> NoiseFloor:
    """Return the noise floor of the tile of so many mosaic pixels that holds the region's centre."""
    rows, columns = floor.variance.shape
    row = min((region.y + region.height // 2) // tile, rows - 1)
    column = min((region.x + region.width // 2) // tile, columns - 1)
    here = (slice(row, row + 1), slice(column, column + 1))
    return replace(floor, variance=floor.variance[here], dof=np.broadcast_to(floor.dof, floor.variance.shape)[here])


def _rows(
    bursts: IsoBursts,
    channel: str,
    figure: MapFigure,
    regions: Sequence[Region],
    variances: Sequence[Measured],
    *,
    crop: Region,
) -> Iterable[Row]:
    write = RowWriter(bursts=bursts).root_and_variance
    pooled = equal_mean(variances)
    for place, variance in ((crop, pooled), *zip(regions, variances, strict=True)):
        yield from write(
            figure.quantity,
            channel,
            figure.method,
            variance,
            figure.unit,
            source=f"{figure.source}, 5.5",
            region=str(place),
            recommended=False,
        )


def _curve(bursts: IsoBursts, channel: str, regions: Sequence[Region], variances: Sequence[Measured]) -> Curve:
    count = len(regions)
    roots = [square_root(one, PERCENT) for one in variances]
    return Curve(
        name="prnu_tiles",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * count),
            Column(name="channel", unit="", values=(channel,) * count),
            Column(name="x", unit="pixel", values=tuple(one.x for one in regions)),
            Column(name="y", unit="pixel", values=tuple(one.y for one in regions)),
            Column(name="width", unit="pixel", values=tuple(one.width for one in regions)),
            Column(name="height", unit="pixel", values=tuple(one.height for one in regions)),
            Column(name="prnu", unit=PERCENT, values=tuple(one.value for one in roots)),
            Column(name="std_error", unit=PERCENT, values=tuple(one.std_error for one in roots)),
        ),
    )


def _told(channel: str, figure: MapFigure, same: Constancy) -> str:
    return f"{figure.quantity.upper()} of {channel} (p = {same.p_value:.2g})"


def _findings(bursts: IsoBursts, uneven: Sequence[str]) -> tuple[Finding, ...]:
    if not uneven:
        return ()
    message = (
        f"tiles of the central crop at {bursts.label} differ by more than their errors: {', '.join(uneven)}; look for "
        "dust, defects or texture in the flats"
    )
    return (Finding(code="tiles-differ", severity=Severity.INFO, message=message),)
