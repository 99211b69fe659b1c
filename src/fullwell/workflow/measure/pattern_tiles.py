"""DSNU and PRNU in sixteen tiles of the central crop, pooled as variances (METHOD 5.5)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.constancy import Constancy, constancy
from fullwell.fit.noise_floor import NoiseFloor
from fullwell.fit.nonuniformity import nonuniformity
from fullwell.fit.pooling import SIGNIFICANCE, equal_mean
from fullwell.statistics.pattern import pattern
from fullwell.units import DN, DN2, ONE, PERCENT, Measured, square_root
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.nonuniformity import PERCENT2, PRNU_METHODS
from fullwell.workflow.measure.pattern_maps import INTERCEPT, ChannelMaps, IsoMaps, floor_of
from fullwell.workflow.measure.regions import Region, central_crop, central_tiles
from fullwell.workflow.measure.section import RowWriter, Section

SMALLEST_EDGE = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """What is asked of every tile: one quantity from one map."""

    quantity: str
    method: str
    source: str
    map_name: str
    relative: bool
    unit: str
    variance_unit: str
    factor: float


_DSNU = _Asked(
    quantity="dsnu",
    method="exposure-intercept",
    source="METHOD 5.2, 5.5",
    map_name=INTERCEPT,
    relative=False,
    unit=DN,
    variance_unit=DN2,
    factor=1.0,
)


def measure_pattern_tiles(bursts: IsoBursts, maps: IsoMaps, *, width: int, height: int) -> Section:
    """Measure DSNU and PRNU of every channel in each of the sixteen tiles, and pool them.

    Parameters
    ----------
    bursts, maps
        Of one ISO.
    width, height
        Of the visible mosaic [pixel].

    """
    cell = 1 if len(maps.channels) == 1 else 2
    regions = central_tiles(width=width, height=height)
    if regions[0].width // cell < SMALLEST_EDGE:
        return Section()
    crop = central_crop(width=width, height=height)
    rows: list[Row] = []
    curves: list[Curve] = []
    uneven: list[str] = []
    for one in maps.channels:
        for asked in (_asked_prnu(one), _DSNU):
            if asked is None or asked.map_name not in one.maps:
                continue
            floor = floor_of(one.combinations[asked.map_name], one.channel)
            variances = [_variance(one, asked, floor, region, cell) for region in regions]
            same = constancy(variances)
            rows += _rows(bursts, one.channel, asked, regions, variances, crop=crop)
            if asked.quantity == "prnu":
                curves.append(_curve(bursts, one.channel, regions, variances))
            if same.p_value < SIGNIFICANCE / len(maps.channels):
                uneven.append(_told(one.channel, asked, same))
    return Section(rows=tuple(rows), curves=tuple(curves), findings=_findings(bursts, uneven))


def _asked_prnu(maps: ChannelMaps) -> _Asked | None:
    for name, method, source in PRNU_METHODS:
        if name in maps.maps:
            return _Asked(
                quantity="prnu",
                method=method,
                source=f"{source}, 5.5",
                map_name=name,
                relative=True,
                unit=PERCENT,
                variance_unit=PERCENT2,
                factor=1e4,
            )
    return None


def _variance(maps: ChannelMaps, asked: _Asked, floor: NoiseFloor, region: Region, cell: int) -> Measured:
    """Return the signed variance of one tile, in the squared unit it is shown in."""
    piece = maps.maps[asked.map_name][region.plane(cell)]
    found = pattern(piece, tile=max(piece.shape), relative=asked.relative)
    size = maps.flats[0].plane(maps.channel).tiles.size
    unit = ONE if asked.relative else DN2
    return nonuniformity(found, _local(floor, size * cell, region), unit=unit).total.scaled(
        asked.factor, asked.variance_unit
    )


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
    asked: _Asked,
    regions: Sequence[Region],
    variances: Sequence[Measured],
    *,
    crop: Region,
) -> Iterable[Row]:
    write = RowWriter(bursts=bursts).root_and_variance
    pooled = equal_mean(variances)
    for place, variance in ((crop, pooled), *zip(regions, variances, strict=True)):
        yield from write(
            asked.quantity,
            channel,
            asked.method,
            variance,
            asked.unit,
            source=asked.source,
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


def _told(channel: str, asked: _Asked, same: Constancy) -> str:
    return f"{asked.quantity.upper()} of {channel} (p = {same.p_value:.2g})"


def _findings(bursts: IsoBursts, uneven: Sequence[str]) -> tuple[Finding, ...]:
    if not uneven:
        return ()
    message = (
        f"tiles of the central crop at {bursts.label} differ by more than their errors: {', '.join(uneven)}; look for "
        "dust, defects or texture in the flats"
    )
    return (Finding(code="tiles-differ", severity=Severity.INFO, message=message),)
