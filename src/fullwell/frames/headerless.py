"""Files without a header: what a sidecar says of them, and whether their pixels bear out what anybody says."""

from pathlib import Path
from typing import Final

from fullwell.errors import UnreadableFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.sidecar import SidecarFacts, read_sidecar, sidecar_of
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.open import read_header

_SAID_BY_SIDECAR: Final = "the sidecar"


def stored_as(facts: SidecarFacts, *, size: int) -> tuple[HeaderlessFormat | None, str]:
    """Return how a sidecar says that a frame without a header is stored, if its size agrees, and who says so."""
    stated = facts.headerless
    return (stated if stated is not None and size in stated.file_sizes else None), _SAID_BY_SIDECAR


def read_stated(path: Path, *, headerless: HeaderlessFormat | None) -> RawHeader:
    """Return a single file's header; without a header of its own, its sidecar is asked before the presets.

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
    if headerless is not None:
        return read_header(path, headerless=headerless)
    sidecar = sidecar_of(path)
    try:
        facts = SidecarFacts() if sidecar is None else read_sidecar(sidecar)
        stated, said_by = stored_as(facts, size=path.stat().st_size)
    except (UnreadableFileError, OSError):
        return read_header(path)
    return read_header(path, headerless=stated, said_by=said_by)


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
