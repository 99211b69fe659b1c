"""Black level and white level per channel: every piece of evidence, and what is made of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import Evidence, FusedLevel, fuse
from fullwell.fit.black_level import declared as declared_level
from fullwell.fit.dark import DarkLine, fit_dark_line
from fullwell.fit.pooling import pool_channels
from fullwell.fit.variance_components import grand_mean_variance
from fullwell.frames.series import Study
from fullwell.statistics.series import Histogram, PlaneStatistics
from fullwell.units import DN, DN2, Measured
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.section import RowWriter, Section

USER = "user"
DARK_FRAMES = "dark-frames"
METADATA = "metadata"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelLevels:
    """What later measurements need of one channel's levels.

    Parameters
    ----------
    black
        The black level used [DN]; None where nothing tells it.
    black_identified
        Whether the frames themselves determine it.
    white_dn
        The highest code the channel can reach [DN]; None where nothing tells it.
    piles_up
        Whether frames were seen to pile up at ``white_dn``.

    """

    channel: str
    black: Measured | None
    black_identified: bool
    white_dn: float | None
    piles_up: bool

    @property
    def black_dn(self) -> float:
        """Return the black level to subtract, 0 where unknown [DN]."""
        return 0.0 if self.black is None else self.black.value


def declared_black(study: Study, channel_index: int) -> float | None:
    """Return the declared black level of one CFA site [DN]."""
    if study.black_level is None or study.black_level.source == "default":
        return None
    values = study.black_level.values
    return values[channel_index if len(values) > 1 else 0]


def declared_white(study: Study, channel_index: int) -> float | None:
    """Return the declared white level of one CFA site [DN]."""
    if study.white_level is None:
        return None
    values = study.white_level.values
    return values[channel_index if len(values) > 1 else 0]


def dark_frames_level(bursts: Sequence[Burst], channels: Sequence[str]) -> Measured | None:
    """Return the mean dark signal extrapolated to no exposure (METHOD 2.3 ii), fixed pattern included in its error.

    Three exposures or more: intercept of the line through burst means, error from their scatter. Fewer: the mean of
    the shortest exposure, error from the frame x row x column layout. Several channels are averaged burst by burst
    before the line is fitted, so that what they share (frame offsets) stays in the error.
    """
    if not bursts:
        return None
    shortest = [bursts[0].plane(channel) for channel in channels]
    spread = [_mean_variances(plane) for plane in shortest]
    total_dn2, temporal_dn2 = (sum(one[part].value for one in spread) / len(spread) ** 2 for part in (0, 1))
    dof = min((one[0].dof for one in spread if one[0].dof is not None), default=None)
    if len({burst.exposure_s for burst in bursts}) < 3:
        mean = sum(plane.mean for plane in shortest) / len(shortest)
        return Measured.student(mean, math.sqrt(total_dn2), dof, DN)
    line = mean_dark_line(bursts, channels).intercept
    return _with_fixed_pattern(line, max(total_dn2 - temporal_dn2, 0.0))


def _with_fixed_pattern(level: Measured, fixed_dn2: float) -> Measured:
    """Add to a temporal standard error what the finite number of pixels leaves open, its dof by Satterthwaite."""
    scatter_dn2 = (level.std_error or 0.0) ** 2
    total_dn2 = scatter_dn2 + fixed_dn2
    dof = None if level.dof is None or scatter_dn2 == 0.0 else level.dof * (total_dn2 / scatter_dn2) ** 2
    return Measured.student(level.value, math.sqrt(total_dn2), dof, DN)


def _mean_variances(plane: PlaneStatistics) -> tuple[Measured, Measured]:
    """Return the variance of the plane's mean with and without its fixed pattern [DN^2]."""
    if plane.frames < 2:
        single = Measured.exact(plane.spatial_variance / plane.n, DN2)
        return single, single
    variances = grand_mean_variance(plane.mean_squares, plane.shape)
    total, temporal = variances.total, variances.temporal
    return replace(total, value=max(total.value, temporal.value)), temporal


def mean_dark_line(bursts: Sequence[Burst], channels: Sequence[str]) -> DarkLine:
    """Fit the line through burst means against exposure, channels averaged burst by burst (METHOD 4.1).

    Weights are those of white pixel noise: frames over temporal variance. Two exposures leave no scatter about the
    line; the error then comes from the scatter of the frames.
    """
    planes = [[burst.plane(channel) for channel in channels] for burst in bursts]
    variances = [sum(_mean_variances(plane)[1].value for plane in group) / len(group) ** 2 for group in planes]
    return fit_dark_line(
        [burst.exposure_s for burst in bursts],
        [sum(plane.mean for plane in group) / len(group) for group in planes],
        weights=[sum(_white_weight(plane) for plane in group) for group in planes],
        mean_std_error_dn=[math.sqrt(variance) for variance in variances],
        mean_dof=[max(burst.frames - 1, 1) for burst in bursts],
    )


def _white_weight(plane: PlaneStatistics) -> float:
    return plane.frames / plane.temporal_variance if plane.temporal_variance > 0.0 else float(plane.frames)


def pile_up(histogram: Histogram) -> bool:
    """Tell whether codes pile up at the top: a falling tail never has more pixels on its last code than before it."""
    counts = histogram.counts
    if len(counts) < 2:
        return False
    return bool(counts[-1] >= 10 and counts[-1] > counts[-2] + 5.0 * np.sqrt(counts[-2] + 1.0))


def measure_levels(study: Study, bursts: IsoBursts) -> tuple[Section, tuple[ChannelLevels, ...]]:
    """Measure black and white level of every channel at one ISO."""
    rows: list[Row] = []
    decided: list[tuple[str, FusedLevel | None, str]] = []
    whites: list[_White] = []
    levels: list[ChannelLevels] = []
    for index, channel in enumerate(bursts.channels):
        evidence = _black_evidence(study, bursts, index)
        fused = _decide(evidence) if evidence else None
        rows += _black_rows(bursts, channel, evidence, fused)
        said = ", ".join(f"{one.method} {one.measured.value:.3f} DN" for one in evidence)
        decided.append((channel, fused, said))
        white = _measure_white(study, bursts, index)
        rows += _white_rows(study, bursts, white)
        whites.append(white)
        levels.append(
            ChannelLevels(
                channel=channel,
                black=None if fused is None else fused.measured,
                black_identified=fused is not None and (fused.identified or fused.preferred == (USER,)),
                white_dn=white.level_dn,
                piles_up=white.piles_up,
            )
        )
    given = any(one is not None and one.preferred == (USER,) for _, one, _ in decided)
    rows += _pooled_black(bursts, levels, given=given)
    findings = (*_black_findings(bursts, decided), *_white_findings(bursts, whites))
    return Section(rows=tuple(rows), findings=findings), tuple(levels)


def _black_evidence(study: Study, bursts: IsoBursts, index: int) -> tuple[Evidence, ...]:
    evidence: list[Evidence] = []
    measured = dark_frames_level(bursts.unlit, [bursts.channels[index]])
    if measured is not None:
        evidence.append(Evidence(method=DARK_FRAMES, measured=measured))
    declared = declared_black(study, index)
    if declared is not None and study.black_level is not None:
        method = USER if study.black_level.source == USER else METADATA
        evidence.append(declared_level(declared, method=method))
    return tuple(evidence)


def _decide(evidence: Sequence[Evidence]) -> FusedLevel:
    """Fuse the evidence; a level given by the user is used as it is, and still checked against the rest."""
    fused = fuse(evidence)
    given = [one for one in evidence if one.method == USER]
    return replace(fused, measured=given[0].measured, preferred=(USER,)) if given else fused


def _black_rows(
    bursts: IsoBursts, channel: str, evidence: Sequence[Evidence], fused: FusedLevel | None
) -> tuple[Row, ...]:
    write = RowWriter(bursts=bursts).row
    n = sum(burst.frames * burst.plane(channel).n for burst in bursts.unlit) or None
    flags: set[str] = set()
    if fused is not None and not fused.identified:
        flags.add("offset-not-identified")
    if fused is not None and fused.preferred == (USER,):
        flags.add(USER)
    rows: list[Row] = []
    if fused is not None:
        rows.append(
            write(
                "black_level", channel, "fused", fused.measured, source="METHOD 2.4", n=n, flags=flags, recommended=True
            )
        )
    for one in evidence:
        declared = one.method in {METADATA, USER}
        disagrees = declared and fused is not None and not fused.consistent
        measured = Measured.exact(one.measured.value, DN) if disagrees else one.measured
        own = {"user"} if one.method == USER else set[str]()
        source = "METHOD 2.3 (v)" if declared else "METHOD 2.3 (ii)"
        rows.append(
            write("black_level", channel, one.method, measured, source=source, n=None if declared else n, flags=own)
        )
    return tuple(rows)


def _black_findings(bursts: IsoBursts, fused: Sequence[tuple[str, FusedLevel | None, str]]) -> tuple[Finding, ...]:
    """Return what is to be said of (channel, fused level, evidence in words)."""
    findings: list[Finding] = []
    unknown = [channel for channel, level, _ in fused if level is None]
    if unknown:
        message = (
            f"nothing tells the black level of {', '.join(unknown)} at {bursts.label}: add dark frames, or give it "
            "with --black"
        )
        findings.append(Finding(code="black-level-unknown", severity=Severity.WARNING, message=message))
    apart = [(channel, level, said) for channel, level, said in fused if level is not None and not level.consistent]
    if apart:
        said = "; ".join(f"{channel}: {said}" for channel, _, said in apart)
        used = " and ".join(apart[0][1].preferred)
        message = f"the evidence for the black level at {bursts.label} disagrees ({said}); {used} is used"
        findings.append(Finding(code="black-levels-disagree", severity=Severity.WARNING, message=message))
    return tuple(findings)


def _pooled_black(bursts: IsoBursts, levels: Sequence[ChannelLevels], *, given: bool) -> tuple[Row, ...]:
    known = [level.black for level in levels if level.black is not None]
    if len(levels) < 2 or len(known) < len(levels):
        return ()
    write = RowWriter(bursts=bursts).row
    pooled, p_value = pool_channels(known)
    identified = all(level.black_identified for level in levels)
    measured = dark_frames_level(bursts.unlit, bursts.channels) if identified and not given else None
    flags = {"channels-differ"} if p_value < 0.01 else set[str]()
    if given:
        flags.add(USER)
    if not identified:
        flags.add("offset-not-identified")
    return (
        write("black_level", "all", "fused", measured or pooled, source="METHOD 2.4", flags=flags, recommended=True),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _White:
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


def _measure_white(study: Study, bursts: IsoBursts, index: int) -> _White:
    channel = bursts.channels[index]
    planes = [burst.plane(channel) for burst in bursts.flats or bursts.unlit]
    seen = max(int(plane.tiles.highest.max()) for plane in planes)
    return _White(
        channel=channel,
        declared=declared_white(study, index),
        seen=seen,
        piles_up=any(_top_code(plane.histogram) == seen and pile_up(plane.histogram) for plane in planes),
        n=sum(plane.n * plane.frames for plane in planes),
    )


def _white_rows(study: Study, bursts: IsoBursts, white: _White) -> tuple[Row, ...]:
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
        source="user" if method == USER else "file metadata",
        flags=(USER,) if method == USER else (),
        recommended=not white.trusted,
    )
    return (seen, declared)


def _top_code(histogram: Histogram) -> int:
    return histogram.first_code + len(histogram.counts) - 1


def _white_findings(bursts: IsoBursts, whites: Sequence[_White]) -> tuple[Finding, ...]:
    findings: list[Finding] = []
    above = [white for white in whites if white.declared is not None and white.seen > white.declared]
    if above:
        said = ", ".join(f"{white.channel} {white.seen} DN" for white in above)
        message = f"codes at {bursts.label} reach above the declared white level {above[0].declared:g} DN: {said}"
        findings.append(Finding(code="white-level-exceeded", severity=Severity.WARNING, message=message))
    below = [white for white in whites if white.piles_up and white.declared is not None and white.seen < white.declared]
    if below:
        said = ", ".join(f"{white.channel} {white.seen} DN" for white in below)
        message = (
            f"codes at {bursts.label} pile up below the declared white level {below[0].declared:g} DN: {said}; that is "
            "used as the white level"
        )
        findings.append(Finding(code="white-level-too-high", severity=Severity.WARNING, message=message))
    return tuple(findings)
