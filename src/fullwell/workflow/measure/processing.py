"""Signs of processing in the camera, from the frames of one ISO (METHOD 0, 1.10, 10.3).

Codes left empty, neighbours whose noise hangs together, lines whose means are steadier than their pixels allow, and
channels that were multiplied: each is named, and rows of noise and gain that it touches carry the flag ``processed``.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.special import fdtr

from fullwell.figures.results import Column, Curve, Row
from fullwell.findings import Finding, Severity
from fullwell.report.numbers import show_exposure, show_signed
from fullwell.statistics.codes import CodeUse, Pattern, code_use
from fullwell.statistics.noise_correlation import REACH, NoiseCorrelation
from fullwell.statistics.series import Histogram
from fullwell.units import ONE
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.code_gaps import PROCESSED, code_findings
from fullwell.workflow.measure.photon_transfer import ChannelTransfer
from fullwell.workflow.measure.second_reading import PairLook, SecondReading
from fullwell.workflow.measure.section import Section

FLAG: Final = "processed"
CORRELATED: Final = 0.03
"""Correlation of next neighbours of a plane from where on a filter is named; brighter-fatter stays below 0.01."""
CORRELATED_ERRORS: Final = 5.0
STEADY: Final = 0.7
"""Mean square of lines over that of pixels below which line means are called corrected."""
STEADY_P: Final = 1e-6
SCALED: Final = 0.03
"""Relative difference of system gains from where on a channel is said to be multiplied."""
SCALED_ERRORS: Final = 5.0
_TOUCHED: Final = (
    "read_noise",
    "system_gain",
    "k_",
    "dsnu",
    "prnu",
    "snr_max",
    "dynamic_range",
    "saturation_capacity",
    "total_dark_noise",
    "dark_noise",
    "dark_current_from_variance",
    "conversion_factor",
    "quantum_efficiency",
    "photon_transfer_offset",
    "sensitivity_threshold",
    "inverse_snr_max",
    "stack_",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Processing:
    """What was found.

    Parameters
    ----------
    section
        Findings and curves.
    channels
        Those that carry the flag.

    """

    section: Section
    channels: frozenset[str]

    def marked(self, rows: Iterable[Row]) -> tuple[Row, ...]:
        """Return rows of noise and gain of processed channels, and of all together, with the flag."""
        return tuple(self._marked(row) for row in rows)

    def _marked(self, row: Row) -> Row:
        own = row.channel in self.channels or (bool(self.channels) and row.channel in {"all", "G"})
        if not own or not row.quantity.startswith(_TOUCHED):
            return row
        return replace(row, flags=tuple(sorted({*row.flags, FLAG})))


def code_uses(bursts: IsoBursts) -> tuple[CodeUse, ...]:
    """Return how each channel uses its codes, over all bursts."""
    every = (*bursts.unlit, *bursts.flats)
    return tuple(code_use(_pooled([burst.plane(channel).histogram for burst in every])) for channel in bursts.channels)


def code_steps(uses: Sequence[CodeUse]) -> tuple[float, ...]:
    """Return the quantization step of each channel: the distance of its codes where they are evenly spaced [DN]."""
    even = {Pattern.STEPPED, Pattern.SCALED_UP}
    return tuple(use.scale if use.pattern in even else 1.0 for use in uses)


def measure_processing(
    bursts: IsoBursts, uses: Sequence[CodeUse], again: SecondReading, transfers: Sequence[ChannelTransfer]
) -> Processing:
    """Look for signs of processing at one ISO.

    Parameters
    ----------
    bursts, uses
        What was read, and how its codes are used, by channel.
    again
        Pairs of frames that neighbours are compared in.
    transfers
        Photon-transfer curves by channel.

    """
    at = f" at {bursts.label}"
    coded = {channel for channel, use in zip(bursts.channels, uses, strict=True) if use.pattern in PROCESSED}
    filtered, filter_findings = _filtered(bursts, again.pairs)
    steady, line_findings = _steady(bursts)
    scaled, gain_findings = _scaled(bursts, transfers)
    curves = (_curve(bursts, again.pairs),) if again.pairs else ()
    findings = (*code_findings(bursts.channels, uses, at=at), *filter_findings, *line_findings, *gain_findings)
    return Processing(
        section=Section(findings=findings, curves=curves), channels=frozenset(coded | filtered | steady | scaled)
    )


def _pooled(histograms: Sequence[Histogram]) -> Histogram:
    first = min(one.first_code for one in histograms)
    last = max(one.first_code + len(one.counts) for one in histograms)
    counts = np.zeros(last - first, np.int64)
    for one in histograms:
        counts[one.first_code - first : one.first_code - first + len(one.counts)] += one.counts
    return Histogram(first_code=first, counts=counts, frames=sum(one.frames for one in histograms))


def _filtered(bursts: IsoBursts, pairs: Sequence[PairLook]) -> tuple[set[str], tuple[Finding, ...]]:
    """Return the channels whose neighbours' noise hangs together beyond what sensors do."""
    channels: set[str] = set()
    findings: list[Finding] = []
    for pair in pairs:
        found = [
            (channel, one)
            for channel, one in zip(bursts.channels, pair.correlations, strict=True)
            if one.variance_dn2 > 0.0 and abs(strongest(one)) > max(CORRELATED, CORRELATED_ERRORS * one.std_error)
        ]
        if not found:
            continue
        channels |= {channel for channel, _ in found}
        said = "; ".join(
            f"{channel} {show_signed(strongest(one), 3)}, the sum over ±{REACH} pixels is "
            f"{one.total_dn2 / one.variance_dn2:.2f} of the variance {one.variance_dn2:.4g} DN²"
            for channel, one in found
        )
        kind = "smoothing (denoised, interpolated or resized)" if strongest(found[0][1]) > 0.0 else "sharpening"
        message = (
            f"The noise of neighbouring pixels of one colour hangs together in {pair.kind.value} frames of "
            f"{show_exposure(pair.exposure_s)} at {bursts.label}: correlation {said}. That is {kind} in the camera: "
            "the variance is not that of the photons; read noise, and K from the variance alone, are off by about that "
            "share."
        )
        findings.append(
            Finding(
                code="correlated-noise", severity=Severity.WARNING, message=message, files=tuple(sorted(pair.files))
            )
        )
    return channels, tuple(findings)


def strongest(one: NoiseCorrelation) -> float:
    """Return the correlation of the next neighbours, along rows or columns, that is farther from zero [1]."""
    row, column = float(one.correlation[0, REACH + 1]), float(one.correlation[1, REACH])
    return max(row, column, key=abs)


def _steady(bursts: IsoBursts) -> tuple[set[str], tuple[Finding, ...]]:
    """Return the channels whose lines are steadier from frame to frame than independent pixels allow."""
    channels: set[str] = set()
    findings: list[Finding] = []
    for lines in ("rows", "columns"):
        found = {
            channel: ratio
            for channel in bursts.channels
            for burst in (*bursts.unlit, *bursts.flats)
            if (ratio := _steadiness(burst, channel, lines)) is not None
        }
        if found:
            channels |= set(found)
            said = ", ".join(f"{channel} {ratio:.2f}" for channel, ratio in found.items())
            message = (
                f"The means of {lines} at {bursts.label} vary less from frame to frame than independent pixels make "
                f"them (variance over what pixels give: {said}): the camera takes an offset per line off that it has "
                "from the same pixels. Line noise comes out too small, and the noise of pixels a little."
            )
            findings.append(Finding(code="line-offsets-corrected", severity=Severity.WARNING, message=message))
    return channels, tuple(findings)


def _steadiness(burst: Burst, channel: str, lines: str) -> float | None:
    """Return the mean square of line means over that of pixels where it is far too small, else None."""
    plane = burst.plane(channel)
    if plane.frames < 2:
        return None
    squares = plane.mean_squares
    mean_square, count = (squares.tv, plane.rows) if lines == "rows" else (squares.th, plane.columns)
    if not squares.tvh > 0.0:
        return None
    dof = (plane.frames - 1) * (count - 1)
    ratio = float(mean_square / squares.tvh)
    beyond = ratio < STEADY and fdtr(dof, dof * (plane.n // count), ratio) < STEADY_P
    return ratio if beyond else None


def _scaled(bursts: IsoBursts, transfers: Sequence[ChannelTransfer]) -> tuple[set[str], tuple[Finding, ...]]:
    """Return the channels whose system gain is not that of the greens: they share the pixel and the amplifier."""
    known = {one.channel: one.system_gain for one in transfers if one.system_gain is not None}
    greens = [known[name] for name in ("G1", "G2") if name in known]
    if len(greens) < 2:
        return set(), ()
    green = sum(one.value for one in greens) / len(greens)
    error = max(one.std_error or 0.0 for one in greens)
    apart = abs(greens[0].value - greens[1].value)
    found = {
        name: known[name].value / green
        for name in ("R", "B")
        if name in known
        and abs(known[name].value - green)
        > max(SCALED * green, SCALED_ERRORS * float(np.hypot(known[name].std_error or 0.0, error)), 3.0 * apart)
    }
    if not found:
        return set(), ()
    said = " and ".join(f"{name} by {ratio:.3f}" for name, ratio in found.items())
    message = (
        f"System gain differs from that of the greens at {bursts.label}: {said}. Pixels and amplifier are the same, so "
        "these channels were multiplied after the converter, as digital white balance does: their K, noise and "
        "saturation in DN hold that factor, figures in electrons do not."
    )
    return set(found), (Finding(code="digital-white-balance", severity=Severity.WARNING, message=message),)


def _curve(bursts: IsoBursts, pairs: Sequence[PairLook]) -> Curve:
    rows = [
        (pair.kind.value, pair.exposure_s, channel, down, right - REACH, float(value), one.std_error)
        for pair in pairs
        for channel, one in zip(bursts.channels, pair.correlations, strict=True)
        if one.variance_dn2 > 0.0
        for (down, right), value in np.ndenumerate(one.correlation)
    ]
    kinds, exposures, channels, downs, rights, values, errors = zip(*rows, strict=True) if rows else ((),) * 7
    return Curve(
        name="noise_correlation",
        columns=(
            Column(name="iso", unit="1", values=(bursts.iso,) * len(rows)),
            Column(name="kind", unit="", values=kinds),
            Column(name="exposure_s", unit="s", values=exposures),
            Column(name="channel", unit="", values=channels),
            Column(name="lag_rows", unit="1", values=downs),
            Column(name="lag_columns", unit="1", values=rights),
            Column(name="correlation", unit=ONE, values=values),
            Column(name="std_error", unit=ONE, values=errors),
        ),
    )
