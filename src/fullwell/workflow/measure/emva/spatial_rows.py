"""Rows of the fixed pattern in the stacks: variances with their sign, DSNU1288 and PRNU1288."""

import math

from fullwell.figures.emva1288.nonuniformity import Split, split_corrected, split_literal
from fullwell.figures.emva1288.sensitivity import LEAST_DARK_VARIANCE
from fullwell.figures.results import Row
from fullwell.units import DN2, PERCENT2, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.emva.stacks import Averages, Stacks, unfiltered_split
from fullwell.workflow.measure.emva.writer import CORRECTED, LINEAR, PACKAGE, ChannelWriter, derived

_PARTS = ("", "_row", "_column", "_pixel")


def filtered_rows(
    bursts: IsoBursts, channel: str, stacks: Stacks, found: Averages, *, system_gain: Measured | None
) -> tuple[Row, ...]:
    """Return the rows of Release 4.0, literally and with the gain of the filter divided out."""
    rows: list[Row] = []
    for method, split in ((LINEAR, split_literal), (CORRECTED, split_corrected)):
        writer = ChannelWriter(bursts=bursts, channel=channel, method=method)
        dark = split(found.dark_moments)
        bright = None if found.bright_moments is None else split(found.bright_moments)
        if method == LINEAR:
            _measured(writer, "dark", stacks.dark, found.dark_moments.measured)
            if stacks.bright is not None and found.bright_moments is not None:
                _measured(writer, "bright", stacks.bright, found.bright_moments.measured)
        _variances(writer, "dark", stacks.dark, dark)
        _dsnu(writer, stacks.dark, dark, system_gain=system_gain)
        if stacks.bright is not None and bright is not None:
            _variances(writer, "bright", stacks.bright, bright)
            _prnu(writer, stacks, dark, bright)
        rows += writer.rows
    return tuple(rows)


def package_spatial_rows(
    bursts: IsoBursts, channel: str, stacks: Stacks, *, system_gain: float | None
) -> tuple[Row, ...]:
    """Return the rows of the package: nothing filtered, no uncertainties; no square root of what lies below zero."""
    writer = ChannelWriter(bursts=bursts, channel=channel, method=PACKAGE, source="EMVA1288-PY")
    splits = {"dark": unfiltered_split(stacks.dark.plane(channel))}
    if stacks.bright is not None:
        splits["bright"] = unfiltered_split(stacks.bright.plane(channel))
    for light, burst in (("dark", stacks.dark), ("bright", stacks.bright)):
        if burst is not None:
            _measured(writer, light, burst, burst.plane(channel).spatial_variance)
            _variances(writer, light, burst, splits[light], exact=True)
    for part, variance in zip(_PARTS, _values(splits["dark"]), strict=True):
        _package_root(writer, f"dsnu{part}", variance, 1.0, "DN")
        if system_gain is not None:
            _package_root(writer, f"dsnu{part}", variance, system_gain, "e-")
    if stacks.bright is not None:
        response = stacks.bright.plane(channel).mean - stacks.dark.plane(channel).mean
        pairs = zip(_values(splits["bright"]), _values(splits["dark"]), strict=True)
        for part, (bright, dark) in zip(_PARTS, pairs, strict=True):
            _package_root(writer, f"prnu{part}", bright - dark, response / 100.0, "%")
    return tuple(writer.rows)


def _values(split: Split) -> tuple[float, float, float, float]:
    return (split.total, split.row, split.column, split.pixel)


def _errors(split: Split) -> tuple[float, float, float, float]:
    return (split.total_error, split.row_error, split.column_error, split.pixel_error)


def _package_root(writer: ChannelWriter, quantity: str, variance: float, over: float, unit: str) -> None:
    """Add a root where there is one, and the signed variance always."""
    flags = () if variance >= 0.0 else ("upper-limit",)
    root = Measured.exact(math.sqrt(max(variance, 0.0)) / over, unit)
    writer.add(quantity, root, equation="results", flags=flags)
    writer.add(f"{quantity}_variance", Measured.exact(variance / over**2, f"{unit}^2"), equation="results")


def _measured(writer: ChannelWriter, light: str, burst: Burst, measured: float) -> None:
    plane = burst.plane(writer.channel)
    n = plane.n * burst.frames
    error = plane.temporal_variance * math.sqrt(2.0 / (plane.n * (burst.frames - 1)))
    exact = writer.method == PACKAGE
    temporal = (
        Measured.exact(plane.temporal_variance, DN2) if exact else Measured.normal(plane.temporal_variance, error, DN2)
    )
    writer.add(f"stack_temporal_variance_{light}", temporal, equation="(65)", n=n)
    spread = measured * math.sqrt(2.0 / plane.n)
    spatial = Measured.exact(measured, DN2) if exact else Measured.normal(measured, spread, DN2)
    writer.add(f"stack_measured_variance_{light}", spatial, equation="(35)", n=n)


def _variances(writer: ChannelWriter, light: str, burst: Burst, split: Split, *, exact: bool = False) -> None:
    n = burst.plane(writer.channel).n * burst.frames
    for part, value, error in zip(_PARTS, _values(split), _errors(split), strict=True):
        measured = Measured.exact(value, DN2) if exact else Measured.normal(value, error, DN2)
        writer.add(f"stack{part}_variance_{light}", measured, equation="(36) (44)", n=n)
    lines = (("column", split.column_means, split.column_error), ("row", split.row_means, split.row_error))
    for name, value, error in lines:
        measured = Measured.exact(value, DN2) if exact else Measured.normal(value, error, DN2)
        writer.add(f"stack_{name}_means_variance_{light}", measured, equation="(38) (41)", n=n)


def _dsnu(writer: ChannelWriter, burst: Burst, split: Split, *, system_gain: Measured | None) -> None:
    """Add the DSNU; less temporal noise than rounding needs to average out lets whole codes hide or fake a pattern."""
    plane = burst.plane(writer.channel)
    n = plane.n * burst.frames
    flags = ("quantization-limited",) if plane.temporal_variance < LEAST_DARK_VARIANCE else ()
    for part, value, error in zip(_PARTS, _values(split), _errors(split), strict=True):
        variance = Measured.normal(value, error, DN2)
        writer.add_root(f"dsnu{part}", variance, "DN", equation="(66)", n=n, flags=flags)
        electrons2 = derived(lambda v: v[0] / v[1] ** 2, variance, system_gain, unit="e-^2")
        if electrons2 is not None:
            writer.add_root(f"dsnu{part}", electrons2, "e-", equation="(66)", n=n, flags=flags)


def _prnu(writer: ChannelWriter, stacks: Stacks, dark: Split, bright: Split) -> None:
    """Add the PRNU; the errors of both stacks are taken as independent, though they share the fixed pattern."""
    if stacks.bright is None:
        return
    flat, unlit = stacks.bright.plane(writer.channel), stacks.dark.plane(writer.channel)
    response = flat.mean - unlit.mean
    if response <= 0.0:
        return
    n = flat.n * stacks.bright.frames
    for part, of_bright, of_dark, error, dark_error in zip(
        _PARTS, _values(bright), _values(dark), _errors(bright), _errors(dark), strict=True
    ):
        scale = (100.0 / response) ** 2
        variance = Measured.normal((of_bright - of_dark) * scale, math.hypot(error, dark_error) * scale, PERCENT2)
        writer.add_root(f"prnu{part}", variance, "%", equation="(67)", n=n)
