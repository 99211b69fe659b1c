"""Whether the frames of a study belong together: what differs is excluded or said as a finding."""

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import Final

from fullwell.findings import Finding, Severity, listed
from fullwell.frames.reading import Reading
from fullwell.frames.series import MEASURED_KINDS, Exclusion, Series

TEMPERATURE_SPREAD_C: Final = 2.0
"""Dark current changes by some 20 % over 2 degrees Celsius (it doubles every 6 to 8)."""


def keep_uniform(readings: Sequence[Reading]) -> tuple[tuple[Reading, ...], tuple[Exclusion, ...]]:
    """Keep the frames that share the size, CFA and bit depth of the majority; exclude the others with the reason."""
    rules: tuple[tuple[str, str, Callable[[Reading], Hashable]], ...] = (
        ("frame-size-differs", "visible size", _size),
        ("cfa-differs", "CFA", lambda one: one.frame.header.cfa),
        ("bit-depth-differs", "bit depth", _code_bits),
    )
    kept, excluded = tuple(readings), list[Exclusion]()
    for code, trait_name, trait in rules:
        if not kept:
            break
        common = _majority(kept, trait)
        excluded += [
            Exclusion(
                name=one.frame.name, code=code, reason=f"its {trait_name} is {trait(one)}, that of most frames {common}"
            )
            for one in kept
            if trait(one) != common
        ]
        kept = tuple(one for one in kept if trait(one) == common)
    kept, mixed = _one_setting_each(kept)
    return kept, (*excluded, *mixed)


def _one_setting_each(readings: Sequence[Reading]) -> tuple[tuple[Reading, ...], tuple[Exclusion, ...]]:
    """Keep, at each ISO, the frames whose camera settings most frames have: others are amplified otherwise."""
    kept: list[Reading] = []
    excluded: list[Exclusion] = []
    for iso in {one.frame.header.iso for one in readings}:
        alike = [one for one in readings if one.frame.header.iso == iso]
        common = str(_majority(alike, _settings))
        kept += [one for one in alike if _settings(one) == common]
        excluded += [
            Exclusion(
                name=one.frame.name,
                code="settings-differ",
                reason=(
                    f"its camera settings are {_settings(one) or 'not told'}, those of most frames "
                    f"{common or 'not told'}; measure it apart, or give each setting its own iso in study.toml"
                ),
            )
            for one in alike
            if _settings(one) != common
        ]
    order = {one.frame.name: place for place, one in enumerate(readings)}
    return tuple(sorted(kept, key=lambda one: order[one.frame.name])), tuple(excluded)


def _settings(one: Reading) -> str:
    return one.frame.header.settings


def _size(one: Reading) -> Hashable:
    return f"{one.frame.header.width} x {one.frame.header.height}"


def _code_bits(one: Reading) -> Hashable:
    """Return the bits that codes up to the declared white level need; without one, the bit depth."""
    white = one.frame.header.white_level
    return one.bit_depth if white is None else int(max(white.values)).bit_length()


def _majority(readings: Sequence[Reading], trait: Callable[[Reading], Hashable]) -> Hashable:
    counts = Counter(trait(one) for one in readings)
    first = {trait(one): one.frame.name for one in sorted(readings, key=lambda one: one.frame.name, reverse=True)}
    return min(counts, key=lambda value: (-counts[value], first[value]))


def exclusion_findings(excluded: Iterable[Exclusion]) -> tuple[Finding, ...]:
    """Return one ``error`` finding per code and reason, naming its files."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for one in excluded:
        reasons.setdefault((one.code, one.reason), []).append(one.name)
    return tuple(
        Finding(
            code=code,
            severity=Severity.ERROR,
            message=f"Left out {listed(sorted(names))}: {reason.rstrip('.')}.",
            files=tuple(sorted(names)),
        )
        for (code, reason), names in sorted(reasons.items())
    )


def study_findings(series: Sequence[Series], readings: Sequence[Reading]) -> tuple[Finding, ...]:
    """Return what is to be said about series that can be used, but with care."""
    return (
        *_iso_unknown(series),
        *_single_frames(series),
        *_temperatures(series),
        *_levels_vary(readings),
        *_cameras(readings),
        *_cfa_overridden(readings),
        *_exposures_overruled(readings),
    )


def _iso_unknown(series: Sequence[Series]) -> Iterator[Finding]:
    unknown = [frame.name for one in series if one.iso is None for frame in one.frames]
    if unknown and any(one.iso is not None for one in series):
        yield Finding(
            code="iso-unknown",
            severity=Severity.WARNING,
            message=(
                f"Nothing says the ISO of {len(unknown)} frames, though other frames have one: they stand apart, as a "
                "group of their own. Put it into a folder name such as ISO_100 or into study.toml (iso)."
            ),
            files=tuple(sorted(unknown)),
        )


def _single_frames(series: Sequence[Series]) -> Iterator[Finding]:
    alone = [one for one in series if len(one.frames) == 1 and one.kind in MEASURED_KINDS]
    if alone:
        yield Finding(
            code="single-frame-series",
            severity=Severity.WARNING,
            message=(
                f"{len(alone)} series hold one frame only: their temporal noise cannot be told from fixed pattern. "
                "Take at least two frames, better four or more, at the same exposure."
            ),
            files=tuple(sorted(one.frames[0].name for one in alone)),
        )


def _temperatures(series: Sequence[Series]) -> Iterator[Finding]:
    conditions = {(one.iso, one.condition_c) for one in series}
    for iso, condition_c in sorted(conditions, key=lambda one: tuple(value or 0.0 for value in one)):
        known = [
            (frame.header.temperature_c, frame.name)
            for one in series
            if (one.iso, one.condition_c) == (iso, condition_c) and one.kind in MEASURED_KINDS
            for frame in one.frames
            if frame.header.temperature_c is not None
        ]
        if known and max(known)[0] - min(known)[0] > TEMPERATURE_SPREAD_C:
            at = "" if iso is None else f" at ISO {iso:g}"
            yield Finding(
                code="temperature-spread",
                severity=Severity.WARNING,
                message=(
                    f"The sensor's temperature ranges from {min(known)[0]:.1f} to {max(known)[0]:.1f} degrees Celsius"
                    f"{at}; dark current doubles about every 6 to 8 degrees. Let the camera warm up before a series."
                ),
                files=(min(known)[1], max(known)[1]),
            )


def _levels_vary(readings: Sequence[Reading]) -> Iterator[Finding]:
    declared = {levels.values for one in readings if (levels := one.frame.header.black_level) is not None}
    if len(declared) > 1:
        spelled = ", ".join("/".join(f"{value:g}" for value in values) for values in sorted(declared))
        yield Finding(
            code="black-level-varies",
            severity=Severity.WARNING,
            message=f"The files declare different black levels ({spelled} DN); the most frequent one is compared with.",
        )


def _cameras(readings: Sequence[Reading]) -> Iterator[Finding]:
    headers = [one.frame.header for one in readings]
    names = {(header.make or "", header.model or "") for header in headers}
    bodies = {(header.make or "", header.model or "", header.serial) for header in headers if header.serial}
    if len(names) > 1 or len(bodies) > 1:
        different = sorted(names if len(names) > 1 else bodies)
        spelled = ", ".join(" ".join(part for part in name if part) or "unnamed" for name in different)
        yield Finding(
            code="cameras-differ",
            severity=Severity.WARNING,
            message=(
                f"The files name different cameras ({spelled}); one study should hold one camera, whose fixed pattern "
                "all its frames share."
            ),
        )


def _cfa_overridden(readings: Sequence[Reading]) -> Iterator[Finding]:
    differing = [one for one in readings if one.own_cfa is not None and one.own_cfa != one.frame.header.cfa]
    if differing:
        yield Finding(
            code="cfa-overridden",
            severity=Severity.WARNING,
            message=(
                f"The files say CFA {differing[0].own_cfa}; {differing[0].frame.header.cfa} was given and is used "
                "instead."
            ),
            files=tuple(sorted(one.frame.name for one in differing)),
        )


def _exposures_overruled(readings: Sequence[Reading]) -> Iterator[Finding]:
    overruled = [
        (abs(stated / named - 1.0), one.frame.name, named, stated)
        for one in readings
        if (stated := one.sidecar_exposure_s) is not None and (named := one.frame.header.exposure_s) is not None
    ]
    if overruled:
        _deviation, worst, named, stated = max(overruled)
        yield Finding(
            code="exposure-ambiguous",
            severity=Severity.WARNING,
            message=(
                f"Names and sidecars of {len(overruled)} frames disagree about the exposure, most for {worst}: "
                f"{named:.6g} s by its name, which is used, {stated:.6g} s by its sidecar. If the sidecars are right, "
                "state exposure_s in study.toml."
            ),
            files=tuple(sorted(name for _deviation, name, _named, _stated in overruled)),
        )


def merged(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Join findings that say the same about several files; the most severe stand first."""
    files: dict[tuple[str, Severity, str], set[str]] = {}
    for finding in findings:
        files.setdefault((finding.code, finding.severity, finding.message), set()).update(finding.files)
    joined = [
        Finding(code=code, severity=severity, message=message, files=tuple(sorted(names)))
        for (code, severity, message), names in files.items()
    ]
    return tuple(sorted(joined, key=lambda one: (one.severity.rank, one.code, one.message)))
