"""A candidate becomes a frame: its header, completed by what the manifest, its name and its sidecar say.

Who is believed first: the user, the manifest, the file's own metadata, its name or a folder's name, the sidecar.
"""

import math
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.headerless import stored_as
from fullwell.frames.naming import exposure_in_path, iso_in_path
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.frames.series import CONTAINER_BITS, Camera, Exclusion, Frame, Kind
from fullwell.frames.sidecar import SidecarFacts, completed, read_sidecar, sidecar_of
from fullwell.frames.source import Candidate, Given
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.open import read_headers


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A frame with what its candidate stated.

    Parameters
    ----------
    frame
        Its header holds the resolved ISO, exposure, temperature and CFA, and the levels the file (or its sidecar)
        declares.
    given
        What the manifest or the descriptor states.
    bit_depth
        From the camera, the sidecar or the file, in this order [bit].
    bit_depth_known
        False where nothing but a 16-bit container is known.
    own_cfa
        What the file itself says.
    sidecar_exposure_s
        The sidecar's exposure where the name's is used and differs from it [s].
    findings
        What reading the frame brought to light.

    """

    kind: Kind
    frame: Frame
    given: Given
    bit_depth: int
    bit_depth_known: bool
    own_cfa: str | None
    sidecar_exposure_s: float | None = None
    findings: tuple[Finding, ...] = ()


def read_all(
    candidates: Iterable[Candidate],
    *,
    camera: Camera,
    cfa: str | None,
    headerless: tuple[HeaderlessFormat, str] | None = None,
) -> tuple[tuple[Reading, ...], tuple[Exclusion, ...]]:
    """Read the headers of all candidates on threads; results stand in the candidates' order.

    Parameters
    ----------
    candidates
        The files.
    camera
        Facts that outrank the files' own.
    cfa
        The user's order, which outranks everything; None where the user gave none.
    headerless
        How files without a header are stored, and who says so; None asks their sidecars, then the presets.

    Raises
    ------
    UsageError
        Where the presets cannot be read.

    """

    def one(candidate: Candidate) -> tuple[Reading | Exclusion, ...]:
        return _read(candidate, camera=camera, cfa=cfa, headerless=headerless)

    with ThreadPoolExecutor(max_workers=min(8, 2 * (os.cpu_count() or 1))) as pool:
        outcomes = tuple(outcome for found in pool.map(one, candidates) for outcome in found)
    readings = tuple(outcome for outcome in outcomes if isinstance(outcome, Reading))
    excluded = tuple(outcome for outcome in outcomes if isinstance(outcome, Exclusion))
    return readings, excluded


def _read(
    candidate: Candidate, *, camera: Camera, cfa: str | None, headerless: tuple[HeaderlessFormat, str] | None
) -> tuple[Reading | Exclusion, ...]:
    """Return what comes of each frame of a file."""
    facts, findings = _sidecar(candidate)
    try:
        size = candidate.path.stat().st_size
        stated, said_by = headerless or stored_as(facts, size=size)
        known = candidate.headers if stated is None else ()
        headers = known or read_headers(candidate.path, headerless=stated, said_by=said_by)
    except (RawFileError, OSError) as error:
        return (Exclusion.of(candidate.name, error),)
    return tuple(
        _outcome(
            header,
            name=_name(candidate, header, frames=len(headers)),
            candidate=candidate,
            size=size,
            facts=facts,
            findings=findings,
            camera=camera,
            cfa=cfa,
        )
        for header in headers
    )


def _name(candidate: Candidate, header: RawHeader, *, frames: int) -> str:
    """Return a frame's name: of many in a file with a number, of as many digits as sorts them."""
    if header.page is None:
        return candidate.name
    return f"{candidate.name}#{header.page:0{len(str(frames))}}"


def _outcome(
    header: RawHeader,
    *,
    name: str,
    candidate: Candidate,
    size: int,
    facts: SidecarFacts,
    findings: tuple[Finding, ...],
    camera: Camera,
    cfa: str | None,
) -> Reading | Exclusion:
    refusals = [finding for finding in header.findings if finding.severity is Severity.ERROR]
    if refusals:
        reason = "; ".join(refusal.message.rstrip(".") for refusal in refusals)
        return Exclusion(name=name, code=refusals[0].code, reason=reason)
    resolved = _resolved(header, candidate=candidate, facts=facts, cfa=cfa or camera.cfa)
    if resolved.exposure_s is None and candidate.kind in {Kind.FLAT, Kind.DARK}:
        return Exclusion(
            name=name,
            code="exposure-unknown",
            reason=(
                f"nothing says the exposure of this {candidate.kind.value} frame: put it into the file's metadata, a "
                "name such as exp2000us, a JSON sidecar (ExposureTime) or study.toml (exposure_s)"
            ),
        )
    depth, known = _bit_depth(header, camera=camera, facts=facts)
    return Reading(
        kind=candidate.kind,
        frame=Frame(
            name=name, header=resolved, size=size if header.extent is None else header.extent.stop - header.extent.start
        ),
        given=candidate.given,
        bit_depth=depth,
        bit_depth_known=known,
        own_cfa=header.cfa,
        sidecar_exposure_s=_overruled(header, candidate=candidate, facts=facts),
        findings=(*_named(header.findings, name), *findings),
    )


def _sidecar(candidate: Candidate) -> tuple[SidecarFacts, tuple[Finding, ...]]:
    path = sidecar_of(candidate.path)
    if path is None:
        return SidecarFacts(), ()
    try:
        return read_sidecar(path), ()
    except UnreadableFileError as error:
        return SidecarFacts(), (
            Finding(code=error.code, severity=Severity.WARNING, message=error.message, files=(candidate.name,)),
        )


def _resolved(header: RawHeader, *, candidate: Candidate, facts: SidecarFacts, cfa: str | None) -> RawHeader:
    given = candidate.given
    whole = completed(header, facts)
    return replace(
        whole,
        iso=_first(given.iso, header.iso, iso_in_path(candidate.name), facts.iso),
        exposure_s=_first(given.exposure_s, header.exposure_s, exposure_in_path(candidate.name), facts.exposure_s),
        temperature_c=_first(given.temperature_c, whole.temperature_c),
        cfa=cfa or whole.cfa,
        bit_depth=header.bit_depth,
    )


def _overruled(header: RawHeader, *, candidate: Candidate, facts: SidecarFacts) -> float | None:
    """Return the sidecar's exposure where the name's is used instead and is another [s]."""
    named_s = exposure_in_path(candidate.name)
    if header.exposure_s is not None or candidate.given.exposure_s is not None or named_s is None:
        return None
    if facts.exposure_s is None or math.isclose(named_s, facts.exposure_s, rel_tol=EXPOSURE_TOLERANCE):
        return None
    return facts.exposure_s


def _bit_depth(header: RawHeader, *, camera: Camera, facts: SidecarFacts) -> tuple[int, bool]:
    """Return the bit depth and whether more is known than the size of the container [bit]."""
    if camera.bit_depth is not None:
        return camera.bit_depth, True
    if facts.bit_depth is not None and facts.bit_depth <= header.bit_depth:
        return facts.bit_depth, True
    return header.bit_depth, header.bit_depth < CONTAINER_BITS or header.white_level is not None


def _named(findings: Iterable[Finding], name: str) -> tuple[Finding, ...]:
    return tuple(replace(finding, files=(name,)) for finding in findings)


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)
