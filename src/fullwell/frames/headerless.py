"""Files without a header: what a sidecar says of them, and whether their pixels bear out what anybody says."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from fullwell.errors import UnreadableFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.sidecar import SidecarFacts, completed, read_sidecar, sidecar_of
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.open import read_header

_SAID_BY_SIDECAR: Final = "the sidecar"
_ADDED: Final = (
    ("cfa", "CFA"),
    ("bit_depth", "bit depth"),
    ("black_level", "black level"),
    ("white_level", "white level"),
    ("iso", "ISO"),
    ("exposure_s", "exposure"),
    ("temperature_c", "temperature"),
    ("make", "make"),
    ("model", "model"),
    ("noise_profile", "noise profile"),
    ("as_shot_neutral", "neutral"),
)
"""What a sidecar can add to a header, and what people call it."""


def stored_as(facts: SidecarFacts, *, size: int) -> tuple[HeaderlessFormat | None, str]:
    """Return how a sidecar says that a frame without a header is stored, if its size agrees, and who says so."""
    stated = facts.headerless
    return (stated if stated is not None and size in stated.file_sizes else None), _SAID_BY_SIDECAR


def read_stated(path: Path, *, headerless: HeaderlessFormat | None) -> RawHeader:
    """Return a single file's header with what its sidecar adds; without a header of its own, presets are asked last.

    Parameters
    ----------
    path
        The file.
    headerless
        How it is stored if it has no header, above all else.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `read_header`.

    """
    sidecar, findings = sidecar_of(path), ()
    facts = SidecarFacts()
    try:
        facts = SidecarFacts() if sidecar is None else read_sidecar(sidecar)
        stated, said_by = stored_as(facts, size=path.stat().st_size)
    except OSError:
        stated, said_by = None, _SAID_BY_SIDECAR
    except UnreadableFileError as error:
        stated, said_by = None, _SAID_BY_SIDECAR
        findings = (Finding(code=error.code, severity=Severity.WARNING, message=error.message),)
    if headerless is not None:
        header = read_header(path, headerless=headerless)
    else:
        header = read_header(path, headerless=stated, said_by=said_by)
    whole = completed(header, facts)
    if sidecar is not None and whole != header:
        findings = (_told_by(sidecar, header, whole),)
    return replace(whole, findings=(*whole.findings, *findings))


def _told_by(sidecar: Path, header: RawHeader, whole: RawHeader) -> Finding:
    """Say what a sidecar added to a header."""
    added = [name for field, name in _ADDED if getattr(whole, field) != getattr(header, field)]
    message = f"Its sidecar {sidecar.name} tells what it does not say itself: {', '.join(added)}."
    return Finding(code="told-by-sidecar", severity=Severity.INFO, message=message)


def geometry_advice(path: Path, code: str) -> tuple[Finding, ...]:
    """Return what a file's content speaks for, where its geometry was refused with one of the codes of that."""
    if code not in {"geometry-mismatch", "geometry-wrong"}:
        return ()
    from fullwell.raw.guess import guess_formats  # noqa: PLC0415 - loads when used

    best = next(iter(guess_formats(path.read_bytes(), name=path.name, most=1)), None)
    if best is None:
        return ()
    message = f"The content speaks for {best.stated} ({best.reason})."
    return (Finding(code="geometry-suggested", severity=Severity.INFO, message=message, files=(str(path),)),)


def geometry_doubts(header: RawHeader, data: bytes) -> tuple[Finding, ...]:
    """Return what the pixels of a headerless file say against its geometry, which its size cannot tell."""
    if not isinstance(header.layout, HeaderlessFormat):
        return ()
    from fullwell.raw.guess import better_geometry  # noqa: PLC0415 - loads when used

    better = better_geometry(header.layout, data)
    if better is None:
        return ()
    message = (
        f"The pixels do not bear this geometry out: neighbours foretell each other far better under {better.stated} "
        f"({better.reason}). `fullwell inspect FILE --guess` shows both."
    )
    return (Finding(code="geometry-doubtful", severity=Severity.WARNING, message=message),)
