"""Dark current from burst means against exposure (METHOD 4)."""

from collections.abc import Sequence

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.dark import DarkLine
from fullwell.fit.legacy.dark import legacy_frame_slope
from fullwell.units import DN
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.dark_level import mean_dark_line
from fullwell.workflow.measure.rounding import rounding_flags
from fullwell.workflow.measure.section import RowWriter, Section


def measure_dark_current(bursts: IsoBursts) -> Section:
    """Measure the slope of the mean dark signal of every channel at one ISO."""
    unlit = bursts.unlit
    if len({burst.exposure_s for burst in unlit}) < 2:
        return Section(findings=(_missing(bursts),))
    usable = tuple(channel for channel in bursts.channels if channel not in bursts.black_clipped)
    groups: list[tuple[str, tuple[str, ...]]] = [(channel, (channel,)) for channel in usable]
    if len(usable) > 1 and usable == bursts.channels:
        groups.append(("all", usable))
    rows: list[Row] = []
    curves: list[Curve] = []
    findings: list[Finding] = []
    for channel, members in groups:
        line = mean_dark_line(unlit, members)
        if line is None:
            continue
        rows += _rows(bursts, channel, members, line)
        if channel in bursts.channels:
            curves.append(_curve(bursts, channel, line))
        if channel == groups[-1][0]:
            findings += _resolution(bursts, line)
    if rows and len(unlit) == 2:
        findings.append(_no_scatter(bursts))
    return Section(rows=tuple(rows), findings=tuple(findings), curves=tuple(curves))


def _no_scatter(bursts: IsoBursts) -> Finding:
    message = (
        f"the unlit frames at {bursts.label} have two exposures: nothing shows whether the level drifts from one burst "
        "to the next, and the errors of black level and dark current leave that out; take them at three or more"
    )
    return Finding(code="two-unlit-exposures", severity=Severity.WARNING, message=message)


def _missing(bursts: IsoBursts) -> Finding:
    message = (
        f"no dark frames of two or more exposures at {bursts.label}: dark current is not measured; "
        "take dark bursts at three exposures or more, the longest as long as the camera allows"
    )
    return Finding(code="no-dark-frames", severity=Severity.WARNING, message=message)


def _rows(bursts: IsoBursts, channel: str, members: Sequence[str], line: DarkLine) -> tuple[Row, ...]:
    write = RowWriter(bursts=bursts).row
    n = sum(burst.plane(member).n * burst.frames for burst in bursts.unlit for member in members)
    limited = rounding_flags(bursts, members)
    rows = [
        write(
            "dark_current", channel, "mean-slope", line.slope, source="METHOD 4.1", n=n, flags=limited, recommended=True
        )
    ]
    darks = bursts.darks
    if len({burst.exposure_s for burst in darks}) >= 2:
        legacy = legacy_frame_slope(
            [burst.exposure_s for burst in darks],
            [sum(float(burst.plane(member).frame_means[0]) for member in members) / len(members) for burst in darks],
        )
        rows.append(
            write(
                "dark_current",
                channel,
                "legacy-frame-slope",
                legacy.slope,
                source="PIXEL4A dark current",
                n=sum(burst.plane(member).n for burst in darks for member in members),
            )
        )
    return tuple(rows)


def _resolution(bursts: IsoBursts, line: DarkLine) -> tuple[Finding, ...]:
    if line.resolvable_slope_dn_per_s is None:
        return ()
    message = (
        f"at {bursts.label} these dark exposures can resolve a dark signal of "
        f"{line.resolvable_slope_dn_per_s:.2g} DN/s (95 %, all channels)"
    )
    longest = max(burst.exposure_s for burst in bursts.unlit)
    if line.exposure_for_10_percent_s is not None and line.exposure_for_10_percent_s > longest:
        message += f"; 10 % precision needs exposures up to {line.exposure_for_10_percent_s:.2g} s"
    return (Finding(code="dark-current-resolution", severity=Severity.INFO, message=message + "."),)


def _curve(bursts: IsoBursts, channel: str, line: DarkLine) -> Curve:
    unlit = bursts.unlit
    count = len(unlit)
    return Curve(
        name="dark_signal",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * count),
            Column(name="channel", unit="", values=(channel,) * count),
            Column(name="kind", unit="", values=tuple(burst.kind.value for burst in unlit)),
            Column(name="exposure_s", unit="s", values=tuple(burst.exposure_s for burst in unlit)),
            Column(name="mean", unit=DN, values=tuple(burst.plane(channel).mean for burst in unlit)),
            Column(name="std_error", unit=DN, values=tuple(burst.plane(channel).mean_std_error for burst in unlit)),
            Column(
                name="fitted",
                unit=DN,
                values=tuple(line.intercept.value + line.slope.value * burst.exposure_s for burst in unlit),
            ),
        ),
    )
