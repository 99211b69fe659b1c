"""Whether what should not know the amplifier is the same at every ISO: PRNU, DSNU and dark current (METHOD 5.6)."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.fit.constancy import Constancy, constancy
from fullwell.fit.pooling import SIGNIFICANCE
from fullwell.glossary import RECOMMENDED
from fullwell.units import ELECTRON, ELECTRON2, ELECTRON_PER_SECOND, PERCENT, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.nonuniformity import ChannelPattern
from fullwell.workflow.measure.section import Section


@dataclass(frozen=True, slots=True, kw_only=True)
class IsoPattern:
    """The fixed pattern of every channel at one ISO."""

    bursts: IsoBursts
    channels: tuple[ChannelPattern, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Tested:
    quantity: str
    channel: str
    unit: str
    mean: float
    same: Constancy


def measure_iso_constancy(patterns: Sequence[IsoPattern], rows: Iterable[Row]) -> Section:
    """Test every channel that was measured at two ISOs or more.

    Parameters
    ----------
    patterns
        One per ISO.
    rows
        Every row; the recommended ones of the system gain and the dark current are used.

    """
    known = [row for row in rows if RECOMMENDED in row.flags and row.iso is not None]
    system_gain = {(row.iso, row.channel): row.measured for row in known if row.quantity == "system_gain"}
    channels = dict.fromkeys(channel for one in patterns for channel in one.bursts.channels)
    tested = [
        one
        for channel in channels
        for one in (
            _prnu(patterns, channel),
            _dsnu(patterns, channel, system_gain),
            _dark_current(known, channel),
        )
        if one is not None
    ]
    tested.sort(key=lambda one: one.quantity)
    return Section(curves=(_curve(tested),), findings=_findings(tested)) if tested else Section()


def _prnu(patterns: Sequence[IsoPattern], channel: str) -> _Tested | None:
    """Compare the same pixels' pattern: only the noise in it may differ from ISO to ISO."""
    found = [one.prnu for group in patterns for one in group.channels if one.channel == channel and one.prnu]
    if len(found) < 2:
        return None
    same = constancy([one.total for one in found], errors=[one.repeat_error for one in found])
    return _Tested(
        quantity="prnu", channel=channel, unit=PERCENT, mean=100.0 * math.sqrt(max(same.mean.value, 0.0)), same=same
    )


def _dsnu(
    patterns: Sequence[IsoPattern], channel: str, system_gain: Mapping[tuple[float | None, str], Measured]
) -> _Tested | None:
    variances: list[Measured] = []
    errors: list[float] = []
    for group in patterns:
        by = system_gain.get((group.bursts.iso, channel))
        own = next((one.dsnu for one in group.channels if one.channel == channel), None)
        if by is None or own is None:
            continue
        variance = own.total.scaled(by.value**-2, ELECTRON2)
        relative = 2.0 * (by.std_error or 0.0) / by.value
        variances.append(variance)
        errors.append(math.hypot(own.repeat_error / by.value**2, relative * variance.value))
    if len(variances) < 2:
        return None
    same = constancy(variances, errors=errors)
    return _Tested(
        quantity="dsnu", channel=channel, unit=ELECTRON, mean=math.sqrt(max(same.mean.value, 0.0)), same=same
    )


def _dark_current(rows: Iterable[Row], channel: str) -> _Tested | None:
    wanted = ("dark_current", channel, ELECTRON_PER_SECOND)
    found = [row.measured for row in rows if (row.quantity, row.channel, row.measured.unit) == wanted]
    found = [one for one in found if one.std_error]
    if len(found) < 2:
        return None
    same = constancy(found)
    return _Tested(quantity="dark_current", channel=channel, unit=ELECTRON_PER_SECOND, mean=same.mean.value, same=same)


def _curve(tested: Sequence[_Tested]) -> Curve:
    return Curve(
        name="iso_constancy",
        columns=(
            Column(name="quantity", unit="", values=tuple(one.quantity for one in tested)),
            Column(name="channel", unit="", values=tuple(one.channel for one in tested)),
            Column(name="unit", unit="", values=tuple(one.unit for one in tested)),
            Column(name="mean", unit="", values=tuple(one.mean for one in tested)),
            Column(name="chi_square", unit="1", values=tuple(one.same.chi_square for one in tested)),
            Column(name="dof", unit="1", values=tuple(one.same.dof for one in tested)),
            Column(name="p_value", unit="1", values=tuple(one.same.p_value for one in tested)),
        ),
    )


def _findings(tested: Sequence[_Tested]) -> tuple[Finding, ...]:
    differing = [one for one in tested if one.same.p_value < SIGNIFICANCE / len(tested)]
    if not differing:
        return ()
    told = ", ".join(f"{one.quantity} of {one.channel} (p = {one.same.p_value:.2g})" for one in differing)
    message = (
        f"not the same at every ISO, beyond their errors: {told}; PRNU, DSNU and dark current in electrons should not "
        "know the amplifier: look for processing of the raw data, temperature or a non-linear response"
    )
    return (Finding(code="iso-dependence", severity=Severity.INFO, message=message),)
