"""Black and white level of a chart's shots: the evidence fused, its disagreement told (METHOD 2.4, 1.11)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import DISAGREEMENT, Evidence, FusedLevel, fuse
from fullwell.fit.pooling import pool_channels
from fullwell.frames.series import Study
from fullwell.raw.cfa import ALL
from fullwell.units import DN, Measured
from fullwell.workflow.measure.chart.evidence import BRACKET, LEGACY, OPTICAL_BLACK, BlackEvidence
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Shots
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.white_level import (
    METADATA,
    USER,
    WhiteLevel,
    declared_white,
    digital_maximum,
    maximum_rows,
    pile_up,
    white_findings,
    white_rows,
)

_SOURCES = {
    BRACKET: "METHOD 2.3 (i)",
    "dark-frames": "METHOD 2.3 (ii)",
    OPTICAL_BLACK: "METHOD 2.3 (iii)",
    METADATA: "METHOD 2.3 (v)",
    USER: "METHOD 2.3 (v)",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BlackLevel:
    """The black level that a channel's signals are counted from.

    Parameters
    ----------
    channel
        Its name, or ``all``.
    level
        With its error [DN].
    identified
        Whether evidence that can tell it stands behind it, or the user's word.

    """

    channel: str
    level: Measured
    identified: bool

    @property
    def error_dn(self) -> float:
        """Return its standard error, 0 where it is taken as exact [DN]."""
        return self.level.std_error or 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartLevels:
    """Levels of all channels.

    Parameters
    ----------
    blacks
        Per channel.
    shared
        The black level of all channels; of the one channel of a monochrome sensor.
    alike
        Whether the channels have one black level: only then are all counted from ``shared``.
    whites
        Per channel.
    digital_maximum
        D of the noise coefficients: the highest code of the converter [DN].

    """

    blacks: tuple[BlackLevel, ...]
    shared: BlackLevel
    alike: bool
    whites: tuple[WhiteLevel, ...]
    digital_maximum: float

    @property
    def own_offsets_dn(self) -> tuple[float, ...]:
        """Return each channel's black level [DN]."""
        return tuple(one.level.value for one in self.blacks)

    @property
    def shared_offsets_dn(self) -> tuple[float, ...]:
        """Return the level that each channel is counted from where all are taken together [DN]."""
        return (self.shared.level.value,) * len(self.blacks) if self.alike else self.own_offsets_dn

    def of(self, channel: str) -> BlackLevel:
        """Return the black level of one channel, or of ``all``."""
        return next((one for one in self.blacks if one.channel == channel), self.shared)

    def ceiling_dn(self, channel: str) -> float:
        """Return white level less black level of a channel, or of ``all`` [DN]."""
        white = next((one.level_dn for one in self.whites if one.channel == channel), None)
        return (white or self.digital_maximum) - self.of(channel).level.value


def measure_whites(study: Study, shots: Shots) -> tuple[WhiteLevel, ...]:
    """Return the white level of every channel: declared, seen, and whether codes pile up there."""
    found: list[WhiteLevel] = []
    for index, (channel, histogram) in enumerate(zip(shots.channels, shots.histograms, strict=True)):
        found.append(
            WhiteLevel(
                channel=channel,
                declared=declared_white(study, index),
                seen=histogram.first_code + len(histogram.counts) - 1,
                piles_up=pile_up(histogram),
                n=int(histogram.counts.sum()),
            )
        )
    return tuple(found)


def chart_maximum(whites: Sequence[WhiteLevel]) -> float:
    """Return D; where nothing tells it, the highest code of as many bits as were seen [DN]."""
    return digital_maximum(whites) or float(2 ** max(white.seen for white in whites).bit_length() - 1)


def _white_unknown(whites: Sequence[WhiteLevel]) -> tuple[Finding, ...]:
    if any(white.level_dn is not None for white in whites):
        return ()
    message = (
        f"nothing tells the white level, and no code piles up at the top: {chart_maximum(whites):g} DN is taken, the "
        "highest code of as many bits as are seen; the k's are relative to it. Give it with --white"
    )
    return (Finding(code="white-level-unknown", severity=Severity.WARNING, message=message),)


def decide_levels(
    study: Study,
    shots: Shots,
    whites: Sequence[WhiteLevel],
    evidence: Sequence[BlackEvidence],
    models: Sequence[ChartModel | None],
    *,
    guess_dn: float,
    legacy: bool,
) -> tuple[Section, ChartLevels]:
    """Fuse the evidence of every channel and of all, and write what each piece says.

    Parameters
    ----------
    study, shots, whites
        What was read.
    evidence
        Per channel, then that of all where there are several.
    models, guess_dn
        A first noise model per channel and the level it counts from, for the reach of what does not identify.
    legacy
        Whether the published optimizer's level is to be used.

    """
    known = [model for model in models if model is not None]
    reach_dn = _reach(shots, known, guess_dn)
    decided = [_decide(one, legacy=legacy, reach_dn=reach_dn) for one in evidence]
    levels = [
        BlackLevel(
            channel=one.channel,
            level=fused.measured,
            identified=fused.identified or fused.preferred == (USER,),
        )
        for one, fused in zip(evidence, decided, strict=True)
    ]
    blacks = tuple(level for level in levels if level.channel in shots.channels)
    _, p_value = pool_channels([one.level for one in blacks])
    alike = p_value >= DISAGREEMENT
    shared = next((level for level in levels if level.channel == ALL), blacks[0])
    rows = [
        row
        for one, fused in zip(evidence, decided, strict=True)
        for row in _black_rows(shots, one, fused, alike=alike or one.channel != ALL)
    ]
    rows += [row for white in whites for row in white_rows(study, shots.bursts, white)]
    rows += maximum_rows(study, shots.bursts, whites, chart_maximum(whites))
    findings = (
        *_findings(shots, evidence, decided),
        *white_findings(whites, at=f" at {shots.bursts.label}"),
        *_white_unknown(whites),
    )
    return Section(rows=tuple(rows), findings=findings), ChartLevels(
        blacks=blacks,
        shared=shared,
        alike=alike,
        whites=tuple(whites),
        digital_maximum=chart_maximum(whites),
    )


def _decide(one: BlackEvidence, *, legacy: bool, reach_dn: float) -> FusedLevel:
    """Fuse; a level or a method that the user asked for is used as it is."""
    published = Evidence(method=LEGACY, measured=Measured.normal(one.legacy.value, reach_dn, DN))
    if legacy or not one.evidence:
        return fuse([published])
    fused = fuse(one.evidence)
    given = [piece for piece in one.evidence if piece.method == USER]
    return replace(fused, measured=given[0].measured, preferred=(USER,)) if given else fused


def _reach(shots: Shots, models: Sequence[ChartModel], guess_dn: float) -> float:
    """Return the standard error of a level that nothing identifies: uniform over all that fits equally well [DN].

    The level lies below the darkest patch, and above where the noise in the dark would vanish (METHOD 2.1).
    """
    darkest = min(point.mean_dn for _, exposure in shots.exposures for point in exposure.points)
    lowest = max((guess_dn - m.coefficients[0] / m.coefficients[1] for m in models if m.coefficients[1] > 0), default=0)
    return max(darkest - max(float(lowest), 0.0), 1.0) / np.sqrt(12.0)


def _black_rows(shots: Shots, one: BlackEvidence, fused: FusedLevel, *, alike: bool) -> tuple[Row, ...]:
    write = RowWriter(bursts=shots.bursts).row
    n = sum(point.n * point.frames for _, exposure in shots.exposures for point in exposure.points
            if one.channel in {ALL, point.channel})  # fmt: skip
    flags = set[str]()
    if not fused.identified and fused.preferred != (USER,):
        flags.add("offset-not-identified")
    if fused.preferred == (USER,):
        flags.add(USER)
    if not alike:
        flags.add("channels-differ")
    misfit = {"model-misfit"} if any(bracket.solved.misfit for bracket in one.brackets) else set[str]()
    rows = [
        write(
            "black_level",
            one.channel,
            "fused",
            fused.measured,
            source="METHOD 2.4",
            n=n,
            flags=flags | (misfit if BRACKET in fused.preferred else set()),
            recommended=True,
        )
    ]
    rows += [_piece_row(shots, one, piece, fused, misfit=misfit, alike=alike, n=n) for piece in _pieces(one)]
    rows.append(
        write(
            "black_level",
            one.channel,
            LEGACY,
            one.legacy,
            source=f"METHOD 2.2, R = {one.ratio:g}",
            n=n,
            flags=("offset-not-identified",),
        )
    )
    return tuple(rows)


def _pieces(one: BlackEvidence) -> tuple[Evidence, ...]:
    return one.evidence if one.set_aside is None else (*one.evidence, one.set_aside)


def _piece_row(
    shots: Shots,
    one: BlackEvidence,
    piece: Evidence,
    fused: FusedLevel,
    *,
    misfit: set[str],
    alike: bool,
    n: int,
) -> Row:
    """Write what one piece of evidence says; a declared level that the others contradict has no error to its name."""
    off = piece.method in {METADATA, USER} and not fused.consistent
    flags = {USER} if piece.method == USER else set[str]()
    if piece.method == BRACKET:
        flags = misfit | (set[str]() if alike else {"channels-differ"})
    return RowWriter(bursts=shots.bursts).row(
        "black_level",
        one.channel,
        piece.method,
        Measured.exact(piece.measured.value, DN) if off else piece.measured,
        source=_SOURCES[piece.method],
        n=n if piece.method == BRACKET else None,
        flags=flags,
    )


def _findings(shots: Shots, evidence: Sequence[BlackEvidence], decided: Sequence[FusedLevel]) -> tuple[Finding, ...]:
    findings: list[Finding] = []
    apart = [(one, fused) for one, fused in zip(evidence, decided, strict=True) if not fused.consistent]
    if apart:
        said = "; ".join(
            f"{one.channel}: " + ", ".join(f"{p.method} {p.measured.value:.3f} DN" for p in one.evidence)
            for one, _ in apart
        )
        used = " and ".join(dict.fromkeys(apart[0][1].preferred))
        spread = max(fused.random_effects_std_error or 0.0 for _, fused in apart)
        message = (
            f"the evidence for the black level disagrees ({said}); {used} is used (a mean of all would be uncertain "
            f"to {spread:.2g} DN)"
        )
        findings.append(Finding(code="black-levels-disagree", severity=Severity.WARNING, message=message))
    if any(bracket.solved.restricted for one in evidence for bracket in one.brackets):
        message = (
            "the response is not a straight line over the whole range: the exposures are proportional only below a "
            "tenth of the white level, and the black level was taken from there"
        )
        findings.append(Finding(code="response-bends", severity=Severity.WARNING, message=message))
    if any(bracket.solved.misfit for one in evidence for bracket in one.brackets):
        message = (
            "the exposures of the scene are not proportional beyond noise: something moved, the light changed its "
            "pattern or the response bends; the error of the black level is scaled up"
        )
        findings.append(Finding(code="bracket-misfit", severity=Severity.WARNING, message=message))
    if any(len(scene.exposures) > 1 for scene in shots.scenes) and not any(one.brackets for one in evidence):
        message = (
            "the exposures of the scene do not tell the black level: they differ too little, or too few patches are "
            "free of clipping in both; take one three to four stops under the other"
        )
        findings.append(Finding(code="bracket-too-narrow", severity=Severity.WARNING, message=message))
    return tuple(findings)
