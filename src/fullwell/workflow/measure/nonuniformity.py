"""DSNU and PRNU: the spatial variance of pixel maps, less the temporal noise left in them (METHOD 5)."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.nonuniformity import Nonuniformity, nonuniformity
from fullwell.fit.pooling import SIGNIFICANCE, SharedErrors, mean_of_sites, pool_channels
from fullwell.report.numbers import show_exposure
from fullwell.statistics.pattern import SMALLEST_SIDE, pattern
from fullwell.units import DN, DN2, ONE, PERCENT, PERCENT2, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.dark_pattern import dark_pattern
from fullwell.workflow.measure.pattern_maps import INTERCEPT, SLOPE, STACK, ChannelMaps, IsoMaps, floor_of
from fullwell.workflow.measure.rounding import rounding_flags
from fullwell.workflow.measure.section import RowWriter, Section

_PARTS = ("row", "column", "pixel")


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFigure:
    """A figure that is read off a map.

    Parameters
    ----------
    map_name
        Of the map.
    quantity, method, source
        As in rows of results.
    relative
        Whether the pattern is relative to the map's surface, shown in %; else in DN.

    """

    map_name: str
    quantity: str
    method: str
    source: str
    relative: bool

    @property
    def variance_unit(self) -> str:
        """The unit of the map's variance."""
        return ONE if self.relative else DN2

    @property
    def unit(self) -> str:
        """The unit it is shown in."""
        return PERCENT if self.relative else DN

    def shown(self, variance: Measured) -> Measured:
        """Return a variance in the squared unit it is shown in."""
        return variance.scaled(1e4, PERCENT2) if self.relative else variance


PRNU_FIGURES = (
    MapFigure(map_name=STACK, quantity="prnu", method="flat-dark-stack", source="METHOD 5.1", relative=True),
    MapFigure(map_name=SLOPE, quantity="prnu", method="exposure-slope", source="METHOD 5.2", relative=True),
)
"""The better one first."""
DSNU_FIGURE = MapFigure(
    map_name=INTERCEPT, quantity="dsnu", method="exposure-intercept", source="METHOD 5.2", relative=False
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelPattern:
    """The recommended fixed pattern of one channel: signed variances of PRNU [1] and DSNU [DN^2], None if unknown."""

    channel: str
    prnu: Nonuniformity | None
    dsnu: Nonuniformity | None


FoundInMaps = Mapping[tuple[str, str], Nonuniformity | None]
"""The fixed pattern of each map that was looked at, by channel and name of the map."""


def look_at_maps(maps: IsoMaps) -> FoundInMaps:
    """Return the fixed pattern of the maps that are there."""
    return {
        (one.channel, figure.map_name): _of_map(one, figure)
        for figure in (*PRNU_FIGURES, DSNU_FIGURE)
        for one in maps.channels
        if figure.map_name in one.maps
    }


def measure_nonuniformity(
    bursts: IsoBursts, maps: IsoMaps, seen: FoundInMaps
) -> tuple[Section, tuple[ChannelPattern, ...]]:
    """Measure DSNU and PRNU of every channel at one ISO, whole and in rows, columns and pixels.

    Parameters
    ----------
    bursts, maps
        Of one ISO; the maps themselves may be gone.
    seen
        What `look_at_maps` found in all of them.

    """
    rows: list[Row] = []
    patterns: list[ChannelPattern] = []
    for one in maps.channels:
        found = ((figure, seen.get((one.channel, figure.map_name))) for figure in PRNU_FIGURES)
        prnu = [(figure, measured) for figure, measured in found if measured is not None]
        dsnu = _dark_stack(bursts, one.channel)
        intercept = seen.get((one.channel, DSNU_FIGURE.map_name))
        for index, (figure, measured) in enumerate(prnu):
            rows += _map_rows(bursts, one, figure, measured, recommended=index == 0)
        rows += _dark_rows(bursts, one.channel, dsnu)
        if intercept is not None:
            rows += _map_rows(bursts, one, DSNU_FIGURE, intercept, recommended=dsnu is None)
        chosen = prnu[0][1] if prnu else None
        patterns.append(ChannelPattern(channel=one.channel, prnu=chosen, dsnu=dsnu or intercept))
    rows += _pooled(bursts, rows)
    return Section(rows=tuple(rows), findings=_findings(bursts, maps, rows)), tuple(patterns)


def _of_map(maps: ChannelMaps, figure: MapFigure) -> Nonuniformity | None:
    """Return the fixed pattern of a map, None where no tile of it is large and light enough."""
    found = pattern(maps.maps[figure.map_name], tile=maps.tile, relative=figure.relative, use=maps.tiles)
    try:
        return nonuniformity(
            found, floor_of(maps.combinations[figure.map_name], maps.channel), unit=figure.variance_unit
        )
    except ValueError:
        return None


def darkest_burst(bursts: IsoBursts) -> Burst | None:
    """Return the unlit burst of two frames or more with the shortest exposure, where dark current adds least."""
    usable = [burst for burst in bursts.unlit if burst.frames > 1]
    return usable[0] if usable else None


def _dark_stack(bursts: IsoBursts, channel: str) -> Nonuniformity | None:
    burst = darkest_burst(bursts)
    if burst is None or channel in bursts.black_clipped:
        return None
    return dark_pattern(burst, channel)[0]


def _map_rows(
    bursts: IsoBursts, maps: ChannelMaps, figure: MapFigure, found: Nonuniformity, *, recommended: bool
) -> tuple[Row, ...]:
    """Return the rows of a figure; intercepts are too noisy to tell rows and columns apart (METHOD 5.2)."""
    told = _whole_and_parts(found) if figure.relative else _whole_and_parts(found)[:1]
    return _written(
        bursts,
        figure.quantity,
        maps.channel,
        figure.method,
        [figure.shown(one) for one in told],
        unit=figure.unit,
        source=figure.source,
        n=sum(burst.frames * burst.plane(maps.channel).n for burst in maps.flats),
        flags=("model-misfit",) if found.misfit else (),
        recommended=recommended,
    )


def _dark_rows(bursts: IsoBursts, channel: str, found: Nonuniformity | None) -> tuple[Row, ...]:
    burst = darkest_burst(bursts)
    if found is None or burst is None:
        return ()
    n = burst.plane(channel).n * burst.frames
    flags = rounding_flags(bursts, [channel])
    whole = _written(
        bursts,
        "dsnu",
        channel,
        "dark-stack",
        _whole_and_parts(found),
        unit=DN,
        source="METHOD 5.1",
        n=n,
        flags=flags,
        recommended=True,
    )
    return (*whole, *_per_exposure(bursts, channel, burst))


def _per_exposure(bursts: IsoBursts, channel: str, shortest: Burst) -> Iterable[Row]:
    """Return the DSNU of every longer dark burst: it grows where dark current differs between pixels."""
    write = RowWriter(bursts=bursts).root_and_variance
    for burst in bursts.darks:
        if burst.frames > 1 and burst is not shortest:
            found, flags = dark_pattern(burst, channel)
            yield from write(
                "dsnu",
                channel,
                "dark-stack",
                found.total,
                DN,
                source="METHOD 5.1",
                n=burst.plane(channel).n * burst.frames,
                exposure_s=burst.exposure_s,
                flags=flags,
                recommended=False,
            )


def _whole_and_parts(found: Nonuniformity) -> tuple[Measured, ...]:
    """Return the variance of a pixel, then its row, column and pixel parts."""
    return (found.total, found.row, found.column, found.pixel)


def _written(
    bursts: IsoBursts,
    quantity: str,
    channel: str,
    method: str,
    variances: Sequence[Measured],
    *,
    unit: str,
    source: str,
    n: int,
    flags: Iterable[str],
    recommended: bool,
) -> tuple[Row, ...]:
    """Return the rows of a non-uniformity: the whole, then its row, column and pixel parts as far as they are given."""
    write = RowWriter(bursts=bursts).root_and_variance
    names = (quantity, *(f"{quantity}_{part}" for part in _PARTS))
    return tuple(
        row
        for name, variance in zip(names, variances, strict=False)
        for row in write(
            name, channel, method, variance, unit, source=source, n=n, flags=flags, recommended=recommended
        )
    )


def _pooled(bursts: IsoBursts, rows: Sequence[Row]) -> tuple[Row, ...]:
    """Return the mean over the channels of every recommended variance, and a flag where the channels differ."""
    pooled: list[Row] = []
    kinds = dict.fromkeys((row.quantity, row.method) for row in rows if "recommended" in row.flags)
    for quantity, method in kinds:
        own = [row for row in rows if (row.quantity, row.method) == (quantity, method) and "recommended" in row.flags]
        if not quantity.endswith("_variance") or len(own) < len(bursts.channels) or len(own) < 2:
            continue
        _, p_value = pool_channels([row.measured for row in own])
        flags = {flag for row in own for flag in row.flags} - {"recommended", "upper-limit"}
        pooled += RowWriter(bursts=bursts).root_and_variance(
            quantity.removesuffix("_variance"),
            "all",
            method,
            mean_of_sites([row.measured for row in own], [_shared_errors(bursts, rows, row) for row in own]),
            PERCENT if own[0].measured.unit == PERCENT2 else DN,
            source=own[0].source,
            n=sum(row.n or 0 for row in own),
            flags=flags | ({"channels-differ"} if p_value < SIGNIFICANCE else set[str]()),
        )
    return tuple(pooled)


def _shared_errors(bursts: IsoBursts, rows: Sequence[Row], row: Row) -> SharedErrors:
    """Return what the pattern of whole rows and columns puts into the error of a variance, or of the part it is of."""
    whole = row.quantity.removesuffix("_variance").split("_")[0]

    def known(part: str, lines: int) -> tuple[float, float]:
        """Return a variance and its degrees of freedom: tiles take some off those of the lines."""
        name = f"{whole}_{part}_variance"
        if row.quantity not in {name, f"{whole}_variance"}:
            return 0.0, 1.0
        same = (one for one in rows if (one.quantity, one.channel, one.method) == (name, row.channel, row.method))
        found = next((one.measured for one in same if one.measured.unit == row.measured.unit), None)
        return (0.0, 1.0) if found is None else (found.value, min(found.dof or math.inf, lines - 1.0))

    _frames, height, width = (*bursts.flats, *bursts.unlit)[0].plane(row.channel).shape
    (by_row, row_dof), (by_column, column_dof) = known("row", height), known("column", width)
    return SharedErrors.of_variances(row=by_row, column=by_column, dof=(1.0, row_dof, column_dof))


def _findings(bursts: IsoBursts, maps: IsoMaps, rows: Sequence[Row]) -> tuple[Finding, ...]:
    if not any(burst.frames > 1 for burst in bursts.flats):
        return ()
    findings: list[Finding] = []
    if any(one.combinations for one in maps.channels) and not any(row.quantity == "prnu" for row in rows):
        message = (
            f"PRNU at {bursts.label} is not measured: no tile is at least {SMALLEST_SIDE} pixels of a plane wide and "
            "above black everywhere; take larger tiles (--tile) or brighter flats"
        )
        findings.append(Finding(code="pattern-not-measured", severity=Severity.WARNING, message=message))
    taken = {burst.series.key for one in maps.channels for burst in one.flats}
    asked = [burst for burst in bursts.flats if burst.frames > 1 and burst.sums is not None]
    left_out = [burst for burst in asked if burst.series.key not in taken]
    if left_out:
        exposures = ", ".join(show_exposure(burst.exposure_s) for burst in left_out)
        message = (
            f"flats of {exposures} at {bursts.label} are saturated, or lie beyond the turn of the variance, in every "
            "channel: PRNU and slopes are measured without them"
        )
        findings.append(Finding(code="flats-saturated", severity=Severity.WARNING, message=message))
    known = [one for one in maps.channels if one.flats]
    if known and not any(STACK in one.combinations for one in known):
        message = (
            f"no dark frames of about the exposure of the flats, or shorter, at {bursts.label}: PRNU comes from the "
            "slope over exposures; take a burst of dark or bias frames to set against the flats"
        )
        findings.append(Finding(code="no-dark-stack", severity=Severity.WARNING, message=message))
    one_flat = known and not any(SLOPE in one.combinations for one in known)
    if one_flat and all(burst.sums is not None for burst in bursts.flats):
        message = (
            f"unsaturated flats of one exposure only at {bursts.label}: slopes and intercepts over exposure are not "
            "measured; take flats at three exposures or more"
        )
        findings.append(Finding(code="one-flat-exposure", severity=Severity.WARNING, message=message))
    return tuple(findings)
