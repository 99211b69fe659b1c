"""What a raw file is: its header, and how many of its bits the codes really use."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError
from fullwell.findings import Finding, Severity
from fullwell.frames.headerless import geometry_advice, geometry_doubts, read_stated
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import RawHeader
from fullwell.raw.open import decode


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """What can be told about one file.

    Parameters
    ----------
    path
        The file.
    header
        None where the file cannot be read at all; the findings say why.
    effective_bits
        Bit depth less the low bits that no code uses; None where no pixel can be read or all are zero [bit].
    findings
        What the file's header and pixels brought to light.

    """

    path: Path
    header: RawHeader | None
    effective_bits: int | None
    findings: tuple[Finding, ...]


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
        effective_bits = used_bits(decode(header, data), bit_depth=header.bit_depth)
        doubts = geometry_doubts(header, data)
    except RawFileError as error:
        known = header.findings if header is not None else ()
        said = any(one.code == error.code for one in known)
        refusal = Finding(code=error.code, severity=Severity.ERROR, message=error.message, files=(str(path),))
        told = known if said else (*known, refusal, *geometry_advice(path, error.code))
        return Inspection(path=path, header=header, effective_bits=None, findings=told)
    findings = (*header.findings, *doubts)
    return Inspection(path=path, header=header, effective_bits=effective_bits, findings=findings)


def used_bits(mosaic: NDArray[np.uint16], *, bit_depth: int) -> int | None:
    """Return the bit depth less the low bits that are zero in every code; None where every code is zero.

    Examples
    --------
    >>> used_bits(np.array([[4, 8], [1020, 12]], dtype=np.uint16), bit_depth=10)
    8

    """
    together = int(np.bitwise_or.reduce(mosaic, axis=None))
    if together == 0:
        return None
    unused = (together & -together).bit_length() - 1
    return bit_depth - unused
