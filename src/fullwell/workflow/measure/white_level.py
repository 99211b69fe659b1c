"""White level per channel: the highest code seen, whether codes pile up there, and what was declared.

Where codes pile up is where a channel ends: with its converter, or before it where its pixels are full. The digital
maximum, which the k's and volts are relative to, is the converter's and one for all channels, whether or not a flat
was bright enough for its pixels to fill.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.frames.series import Study
from fullwell.raw.cfa import ALL
from fullwell.statistics.series import Histogram
from fullwell.units import DN, Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.section import RowWriter

USER = "user"
METADATA = "metadata"


def declared_white(study: Study, channel_index: int) -> float | None:
    """Return the declared white level of one CFA site [DN]."""
    if study.white_level is None:
        return None
    values = study.white_level.values
    return values[channel_index if len(values) > 1 else 0]


def pile_up(histogram: Histogram) -> bool:
    """Tell whether codes pile up at the top: a falling tail never has more pixels on its last code than before it."""
    counts = histogram.counts
    if len(counts) < 2:
        return False
    return bool(counts[-1] >= 10 and counts[-1] > counts[-2] + 5.0 * np.sqrt(counts[-2] + 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class WhiteLevel:
    """What is known of one channel's white level: declared, seen, and whether codes pile up there [DN]."""

    channel: str
    declared: float | None
    seen: int
    piles_up: bool
    n: int

    @property
    def trusted(self) -> bool:
        """Tell whether what was seen is used rather than what was declared."""
        return self.piles_up or self.declared is None

    @property
    def level_dn(self) -> float | None:
        """Return the level to use, None where nothing tells it [DN]."""
        return float(self.seen) if self.piles_up else self.declared

    @property
    def converter_ends(self) -> bool:
        """Tell whether codes pile up where only a converter ends: above what is declared, or on a code of all ones."""
        above = self.declared is None or self.seen > self.declared
        return self.piles_up and (above or self.seen & (self.seen + 1) == 0)


def digital_maximum(whites: Sequence[WhiteLevel]) -> float | None:
    """Return D, the highest code of the converter; None where nothing tells it (METHOD 0) [DN]."""
    seen = max((white.seen for white in whites if white.converter_ends), default=None)
    declared = max((white.declared for white in whites if white.declared is not None), default=None)
    return declared if seen is None else float(seen)


def measure_white(study: Study, bursts: IsoBursts, index: int) -> WhiteLevel:
    """Look for the highest code of one CFA site, in flats where there are any, and for codes piling up there."""
    channel = bursts.channels[index]
    planes = [burst.plane(channel) for burst in bursts.flats or bursts.unlit]
    seen = max(int(plane.tiles.highest.max()) for plane in planes)
    histograms = [plane.histogram for plane in planes]
    return WhiteLevel(
        channel=channel,
        declared=declared_white(study, index),
        seen=seen,
        piles_up=any(_top_code(one) == seen and pile_up(one) for one in histograms)
        or (bool(bursts.flats) and _all_at_top(histograms, seen=seen)),
        n=sum(plane.n * plane.frames for plane in planes),
    )


def white_rows(study: Study, bursts: IsoBursts, white: WhiteLevel) -> tuple[Row, ...]:
    """Return what was seen and what was declared, the trusted one recommended."""
    write = RowWriter(bursts=bursts).row
    seen = write(
        "white_level",
        white.channel,
        "measured",
        Measured.exact(white.seen, DN),
        source="METHOD 1.11",
        n=white.n,
        flags=() if white.piles_up else ("lower-bound",),
        recommended=white.trusted,
    )
    if white.declared is None or study.white_level is None:
        return (seen,)
    method = USER if study.white_level.source == USER else METADATA
    declared = write(
        "white_level",
        white.channel,
        method,
        Measured.exact(white.declared, DN),
        source="user" if method == USER else "file",
        flags=(USER,) if method == USER else (),
        recommended=not white.trusted,
    )
    return (seen, declared)


def maximum_rows(
    study: Study, bursts: IsoBursts, whites: Sequence[WhiteLevel], maximum_dn: float | None
) -> tuple[Row, ...]:
    """Return the digital maximum of every channel, and of all; nothing where it is not known."""
    if maximum_dn is None:
        return ()
    ends = any(white.converter_ends for white in whites)
    declared = None if ends else study.white_level
    method = "measured" if declared is None else USER if declared.source == USER else METADATA
    write = RowWriter(bursts=bursts).row
    return tuple(
        write(
            "digital_maximum",
            channel,
            method,
            Measured.exact(maximum_dn, DN),
            source="METHOD 0",
            flags=(USER,) if method == USER else () if ends or declared else ("lower-bound",),
            recommended=True,
        )
        for channel in (*(white.channel for white in whites), *((ALL,) if len(whites) > 1 else ()))
    )


def _all_at_top(histograms: Sequence[Histogram], *, seen: int) -> bool:
    """Tell whether some flats hold the highest code alone while dimmer ones scatter: more light never scatters less."""
    alone = any(len(one.counts) == 1 and one.first_code == seen for one in histograms)
    return alone and any(len(one.counts) > 1 and _top_code(one) < seen for one in histograms)


def _top_code(histogram: Histogram) -> int:
    return histogram.first_code + len(histogram.counts) - 1


def white_findings(whites: Sequence[WhiteLevel], *, at: str = "") -> tuple[Finding, ...]:
    """Return where what was seen and what was declared disagree; ``at`` says where, with a blank before it."""
    findings: list[Finding] = []
    above = [white for white in whites if white.declared is not None and white.seen > white.declared]
    if above:
        said = ", ".join(f"{white.channel} {white.seen} DN" for white in above)
        message = f"codes{at} reach above the declared white level {above[0].declared:g} DN: {said}"
        findings.append(Finding(code="white-level-exceeded", severity=Severity.WARNING, message=message))
    below = [white for white in whites if white.piles_up and white.declared is not None and white.seen < white.declared]
    if below:
        said = ", ".join(f"{white.channel} {white.seen} DN" for white in below)
        message = (
            f"codes{at} pile up below the declared white level {below[0].declared:g} DN: {said}; that is "
            "used as the white level"
        )
        findings.append(Finding(code="white-level-too-high", severity=Severity.WARNING, message=message))
    return tuple(findings)
