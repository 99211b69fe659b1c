"""What a raw file is: its header, and what its pixels tell of it."""

from dataclasses import dataclass
from pathlib import Path

from fullwell.errors import RawFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.headerless import geometry_advice, geometry_doubts, read_stated
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.open import decode
from fullwell.workflow.signs.content import Content, look_at


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """What can be told about one file.

    Parameters
    ----------
    path
        The file.
    header
        None where the file cannot be read at all; the findings say why.
    content
        What the pixels tell; None where none can be read.
    findings
        What the file's header and pixels brought to light.

    """

    path: Path
    header: RawHeader | None
    content: Content | None
    findings: tuple[Finding, ...]

    @property
    def effective_bits(self) -> int | None:
        """Return the bits that the codes really use; None where nothing tells [bit]."""
        return None if self.content is None else self.content.effective_bits


def inspect_file(path: Path, *, headerless: HeaderlessFormat | None = None) -> Inspection:
    """Read a file's header and pixels; what goes wrong with the file becomes a finding.

    Parameters
    ----------
    path
        The file.
    headerless
        How it is stored if it has no header; None asks its sidecar, then the presets.

    """
    header: RawHeader | None = None
    try:
        header = read_stated(path, headerless=headerless)
        data = path.read_bytes()
        content = look_at(header, data, decode(header, data))
        doubts = geometry_doubts(header, data)
    except RawFileError as error:
        known = header.findings if header is not None else ()
        said = any(one.code == error.code for one in known)
        refusal = Finding(code=error.code, severity=Severity.ERROR, message=error.message, files=(str(path),))
        told = known if said else (*known, refusal, *geometry_advice(path, error.code))
        return Inspection(path=path, header=header, content=None, findings=told)
    findings = (*header.findings, *doubts, *content.findings)
    return Inspection(path=path, header=header, content=content, findings=findings)
