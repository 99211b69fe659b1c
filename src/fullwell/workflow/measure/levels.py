"""Black level and white level per channel: every piece of evidence, and what is made of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fullwell.figures.results import Row
from fullwell.findings import Finding, Severity
from fullwell.fit.black_level import Evidence, FusedLevel, fuse
from fullwell.fit.black_level import declared as declared_level
from fullwell.fit.pooling import SIGNIFICANCE, mean_sharing_errors, pool_channels
from fullwell.frames.series import Study
from fullwell.report.numbers import show_exposure
from fullwell.units import DN, Measured
from fullwell.workflow.masked import MaskedArea
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.dark_level import dark_frames_level, single_burst_level
from fullwell.workflow.measure.optical_black import OPTICAL_BLACK, masked_evidence, masked_findings, masked_rows
from fullwell.workflow.measure.rounding import rounding_flags
from fullwell.workflow.measure.section import RowWriter, Section
from fullwell.workflow.measure.white_level import (
    METADATA,
    USER,
    WhiteLevel,
    digital_maximum,
    maximum_rows,
    white_findings,
    white_rows,
)

DARK_FRAMES = "dark-frames"


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
    digital_maximum_dn
        D of the k's and volts, the same for all channels [DN]; None where nothing tells it.

    """

    channel: str
    black: Measured | None
    black_identified: bool
    white_dn: float | None
    digital_maximum_dn: float | None

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


def measure_levels(
    study: Study, bursts: IsoBursts, whites: Sequence[WhiteLevel], *, masked: Sequence[MaskedArea] = ()
) -> tuple[Section, tuple[ChannelLevels, ...]]:
    """Measure the black level of every channel at one ISO, and tell its white level.

    Parameters
    ----------
    study, bursts, whites
        What was read.
    masked
        Masked pixels by channel; empty where the files have none.

    """
    rows: list[Row] = []
    decided: list[tuple[str, FusedLevel | None, str]] = []
    levels: list[ChannelLevels] = []
    maximum_dn = digital_maximum(whites)
    for index, white in enumerate(whites):
        channel = white.channel
        evidence = _black_evidence(study, bursts, index, masked[index] if masked else None)
        fused = _decide(evidence) if evidence else None
        rows += _black_rows(bursts, channel, evidence, fused)
        rows += _inseparable_rows(bursts, channel)
        rows += white_rows(study, bursts, white)
        said = ", ".join(f"{one.method} {one.measured.value:.3f} DN" for one in evidence)
        decided.append((channel, fused, said))
        levels.append(
            ChannelLevels(
                channel=channel,
                black=None if fused is None else fused.measured,
                black_identified=fused is not None and (fused.identified or fused.preferred == (USER,)),
                white_dn=white.level_dn,
                digital_maximum_dn=maximum_dn,
            )
        )
    given = any(one is not None and one.preferred == (USER,) for _, one, _ in decided)
    rows += _pooled_black(study, bursts, levels, given=given)
    rows += masked_rows(masked, bursts)
    rows += maximum_rows(study, bursts, whites, maximum_dn)
    darks = [_from_darks(bursts, channel) for channel in bursts.channels]
    findings = (
        *_black_findings(bursts, decided),
        *masked_findings(masked, darks, bursts),
        *white_findings(whites, at=f" at {bursts.label}"),
    )
    return Section(rows=tuple(rows), findings=findings), tuple(levels)


def inseparable_burst(bursts: IsoBursts) -> Burst | None:
    """Return the dark burst that is the only unlit one: its level and its dark signal cannot be told apart."""
    only = len({burst.exposure_s for burst in bursts.unlit}) == 1 and not bursts.biases
    return bursts.darks[0] if only else None


def _from_darks(bursts: IsoBursts, channel: str) -> Measured | None:
    """Return what the unlit frames say of a channel's black level; None where they say nothing, or are clipped."""
    usable = () if channel in bursts.black_clipped else bursts.unlit
    measured = dark_frames_level(usable, [channel])
    return measured if measured is not None and measured.std_error else None


def _black_evidence(study: Study, bursts: IsoBursts, index: int, area: MaskedArea | None) -> tuple[Evidence, ...]:
    """Return the evidence: masked pixels count only where no dark frames tell, since they are not the active area."""
    evidence: list[Evidence] = []
    measured = _from_darks(bursts, bursts.channels[index])
    if measured is not None:
        evidence.append(Evidence(method=DARK_FRAMES, measured=measured))
    elif (masked := masked_evidence(area, bursts)) is not None:
        evidence.append(masked)
    declared = declared_black(study, index)
    if declared is not None and study.black_level is not None:
        method = USER if study.black_level.source == USER else METADATA
        evidence.append(declared_level(declared, method=method))
    return tuple(evidence)


def _fused_mean(study: Study, bursts: IsoBursts) -> Measured | None:
    """Return what unlit frames and metadata say of the mean of all channels; None where unlit frames do not tell it."""
    measured = dark_frames_level(bursts.unlit, bursts.channels)
    if measured is None or not measured.std_error:
        return measured
    declared = [level for index in range(len(bursts.channels)) if (level := declared_black(study, index)) is not None]
    evidence = [Evidence(method=DARK_FRAMES, measured=measured)]
    if declared:
        evidence.append(declared_level(sum(declared) / len(declared)))
    return fuse(evidence).measured


def _inseparable_rows(bursts: IsoBursts, channel: str) -> tuple[Row, ...]:
    """Return the mean of dark frames of one exposure as what it is: black level and dark signal together."""
    burst = inseparable_burst(bursts)
    if burst is None or channel in bursts.black_clipped:
        return ()
    plane = burst.plane(channel)
    return (
        RowWriter(bursts=bursts).row(
            "black_level",
            channel,
            DARK_FRAMES,
            single_burst_level(burst, [channel]),
            source="METHOD 2.3 (ii)",
            n=plane.n * plane.frames,
            exposure_s=burst.exposure_s,
            flags=("mixed",),
        ),
    )


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
    flags |= rounding_flags(bursts, [channel])
    rows: list[Row] = []
    if fused is not None:
        rows.append(
            write(
                "black_level", channel, "fused", fused.measured, source="METHOD 2.4", n=n, flags=flags, recommended=True
            )
        )
    for one in evidence:
        if one.method == OPTICAL_BLACK:
            continue
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
    burst = inseparable_burst(bursts)
    if burst is not None:
        message = (
            f"the only unlit frames at {bursts.label} are dark frames of {show_exposure(burst.exposure_s)}: their mean "
            "holds the dark signal too and is not taken for the black level; add bias frames, or dark frames of "
            "other exposures"
        )
        findings.append(Finding(code="one-dark-exposure", severity=Severity.WARNING, message=message))
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


def _pooled_black(study: Study, bursts: IsoBursts, levels: Sequence[ChannelLevels], *, given: bool) -> tuple[Row, ...]:
    known = [level.black for level in levels if level.black is not None]
    if len(levels) < 2 or len(known) < len(levels):
        return ()
    identified = all(level.black_identified for level in levels)
    measured = _fused_mean(study, bursts) if identified and not given else None
    _, p_value = pool_channels(known)
    flags = {"channels-differ"} if p_value < SIGNIFICANCE else set[str]()
    if given:
        flags.add(USER)
    if not identified:
        flags.add("offset-not-identified")
    flags |= rounding_flags(bursts, bursts.channels)
    pooled = measured or mean_sharing_errors(known)
    write = RowWriter(bursts=bursts).row
    return (write("black_level", "all", "fused", pooled, source="METHOD 2.4", flags=flags, recommended=True),)
