"""How a maker's raw file codes its pixels, and whether that changes their noise.

Lossless coding and packing leave every code as the converter gave it. Lossy coding rounds codes, by more where the
picture is brighter or busier: what it does to noise depends on the scene, so it cannot be taken out again.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fullwell.findings import Finding, Severity
from fullwell.raw.description import Description
from fullwell.raw.tags import Tag

_SET_LOSSLESS: Final = "set the camera to lossless or uncompressed raw"
_RAW_DIRECTORIES: Final = ("EXIF SubIFD", "Image", "IFD ")
_NEF_COMPRESSION: Final = 0x0093
_NEF_NAMES: Final = {
    1: "nikon-lossy", 2: "none", 3: "nikon-lossless", 4: "nikon-lossy", 5: "packed", 6: "packed", 7: "none",
    8: "nikon-small", 9: "packed", 10: "packed", 13: "nikon-high-efficiency", 14: "nikon-high-efficiency",
}  # fmt: skip
_SONY_FILE_TYPE: Final = 0x7000
_SONY_NAMES: Final = {0: "none", 1: "none", 2: "sony-lossy", 3: "sony-lossless", 4: "sony-lossless", 6: "sony-lossy"}
_SONY_COMPRESSED: Final = 32767
_TIFF_NAMES: Final = {
    32769: "packed", 32770: "samsung", 32772: "samsung", 32773: "samsung", 34713: "nikon", 65000: "kodak",
    65535: "pentax", 32767: "sony",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Coding:
    """How pixels are coded.

    Parameters
    ----------
    name
        For `RawHeader.compression`; ``maker`` where nothing tells.
    refusal
        Code and reason of a file that must not be measured for it; None for others.
    findings
        What else is to be said.

    """

    name: str
    refusal: tuple[str, str] | None = None
    findings: tuple[Finding, ...] = ()


def coding_of(said: Description, *, make: str | None) -> Coding:
    """Return how a file's pixels are coded, by its maker's own tags."""
    rule = next((rule for start, rule in _RULES.items() if (make or "").casefold().startswith(start)), _other)
    return rule(said)


def _nikon(said: Description) -> Coding:
    number = said.tags.number(_NEF_COMPRESSION, "MakerNote")
    name = _NEF_NAMES.get(int(number or 0), "maker")
    if name == "nikon-small":
        return Coding(name=name, refusal=("processed-rgb", "it is a small raw file (sNEF), computed from the mosaic"))
    return _told(name) if number else _other(said)


def _sony(said: Description) -> Coding:
    number = said.tags.number(_SONY_FILE_TYPE, *_RAW_DIRECTORIES)
    if number is not None and int(number) in _SONY_NAMES:
        return _told(_SONY_NAMES[int(number)])
    bytes_stored = said.tags.number(Tag.STRIP_BYTE_COUNTS, "EXIF SubIFD")
    if said.tags.number(Tag.COMPRESSION, "EXIF SubIFD") == _SONY_COMPRESSED and bytes_stored is not None:
        pixels = 0 if said.decoded is None else said.decoded.raw_height * said.decoded.raw_width
        return _told("sony-lossy" if bytes_stored == pixels else "sony-lossless")
    return _other(said)


def _canon(said: Description) -> Coding:
    if said.container.wavelet_levels > 0:
        return _told("canon-lossy")
    if said.decoded is not None and said.decoded.flat:
        return Coding(name="canon-lossless")
    return _other(said)


def _fujifilm(said: Description) -> Coding:
    return _told("fujifilm-lossy") if said.container.fuji_lossy else _other(said)


def _panasonic(said: Description) -> Coding:
    message = (
        "Its pixels are coded in blocks that store differences, shortened where neighbours differ much: flat fields "
        "and dark frames keep their codes, edges and hot pixels may not."
    )
    finding = Finding(code="block-coded", severity=Severity.INFO, message=message)
    return Coding(name=_other(said).name, findings=(finding,))


def _other(said: Description) -> Coding:
    numbers = [said.tags.number(Tag.COMPRESSION, directory) for directory in _RAW_DIRECTORIES]
    known = [_TIFF_NAMES[int(number)] for number in numbers if number is not None and int(number) in _TIFF_NAMES]
    return Coding(name=known[0] if known else "maker")


def _told(name: str) -> Coding:
    """Return a coding by its name; one that loses is refused."""
    if name.endswith("-lossy") or name == "nikon-high-efficiency":
        shown = name.replace("-", " ")
        reason = f"its coding is {shown}, which rounds codes and so changes their noise; {_SET_LOSSLESS}"
        return Coding(name=name, refusal=("lossy-compression", reason))
    return Coding(name=name)


_RULES: Final[Mapping[str, Callable[[Description], Coding]]] = {
    "nikon": _nikon,
    "sony": _sony,
    "canon": _canon,
    "fuji": _fujifilm,
    "panasonic": _panasonic,
    "leica": _panasonic,
}
