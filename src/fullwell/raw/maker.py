"""Makers' raw files (CR2, CR3, NEF, ARW, RAF, ...): what LibRaw and the makers' own tags say, as a header.

The margins beside the visible mosaic are handed on as masked areas where they are dark, so that the black level can be
measured rather than believed. A file that must not be measured has a header all the same: it says why in a finding of
severity ``error``.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.description import Decoded, Description
from fullwell.raw.image import D65, Area, ColourMatrix, Levels, RawHeader
from fullwell.raw.isolation import ask
from fullwell.raw.maker_coding import Coding, coding_of
from fullwell.raw.maker_facts import ShotFacts, level_tags, shot_facts, stored_end
from fullwell.raw.segments import MAX_PIXELS

SUFFIXES: Final = frozenset(
    {
        ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".erf", ".fff", ".iiq", ".kdc", ".mdc", ".mef", ".mos",
        ".mrw", ".nef", ".nrw", ".orf", ".pef", ".raf", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f",
    }
)  # fmt: skip
"""Endings of files that are handed to LibRaw, whatever they begin with."""

_SIGNATURES: Final = (
    (0, b"FUJIFILMCCD-RAW"), (0, b"FOVb"), (0, b"\0MRM"), (0, b"IIRO"), (0, b"IIRS"), (0, b"MMOR"), (0, b"IIU\0"),
    (4, b"ftypcrx "), (6, b"HEAPCCDR"), (8, b"CR\x02\0"), (8, b"IIII"), (8, b"MMMM"),
)  # fmt: skip
_COMPANDED_WHITE: Final = 255
"""A maker raw of eight bits has been through a tone curve: sensors have more."""
_ORIENTATIONS: Final = {0: 1, 3: 3, 5: 8, 6: 6}
"""LibRaw's ``flip`` as the TIFF tag Orientation has it."""
_DARK_MARGIN: Final = 0.1
"""A margin is masked where it is brighter than the black level by no more than this part of what is visible."""
_LEAST_MARGIN_DN: Final = 8.0
_MOST_COLOUR: Final = 100.0
"""Ratios of white balance and numbers of a colour matrix from which on they are damaged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MakerLayout:
    """Marks a header whose pixels LibRaw decodes."""


def is_maker(path: Path, head: bytes) -> bool:
    """Return whether a file is a maker's raw file, by its first bytes or its ending."""
    return path.suffix.lower() in SUFFIXES or any(head[at : at + len(mark)] == mark for at, mark in _SIGNATURES)


def read_maker_header(path: Path) -> RawHeader:
    """Return the header of a maker's raw file.

    Raises
    ------
    UnreadableFileError
        ``not-a-raw-file``, ``file-damaged`` or ``decoder-failed`` where LibRaw does not read it.
    UnsuitableFileError
        ``unsupported-camera`` where LibRaw does not know the camera, ``lossy-compression`` where it cannot decode it.

    """
    data = path.read_bytes()
    said = Description.from_plain(ask("describe", data))
    facts = shot_facts(said)
    coding = coding_of(said, make=facts.make)
    end = max(stored_end(said.tags), said.container.end)
    if said.decoded is None:
        raise _refused(said.refusal, facts=facts, coding=coding, whole=end <= len(data))
    if said.decoded.last_row_is_flat and end > len(data):
        raise _cut_short()
    if said.decoded.raw_width * said.decoded.raw_height > MAX_PIXELS:
        raise UnreadableFileError("file-damaged", "its header gives no possible size; copy the file again")
    return _header(path, said, said.decoded, facts=facts, coding=coding)


def decode_maker(header: RawHeader, data: memoryview, *, out: NDArray[np.uint16] | None = None) -> NDArray[np.uint16]:
    """Return the visible mosaic of a maker's raw file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where LibRaw does not decode it, or finds another size than its header told;
        ``decoder-failed``.

    """
    shape = (header.height, header.width)
    mosaic = out if out is not None and out.shape == shape else np.empty(shape, np.uint16)
    ask("unpack", data, out=mosaic, area=list(header.active_area), shape=[header.raw_height, header.raw_width])
    return mosaic


def _refused(said: tuple[str, str] | None, *, facts: ShotFacts, coding: Coding, whole: bool) -> RawFileError:
    """Return why a file that LibRaw does not read is of no use: cut short, its coding, its camera, or damaged."""
    code, message = said or ("not-a-raw-file", "LibRaw does not read it")
    if not whole:
        return _cut_short()
    if coding.refusal is not None:
        return UnsuitableFileError(*coding.refusal)
    if code == "not-a-raw-file" and facts.make is not None:
        name = f"{facts.make} {(facts.model or '').removeprefix(facts.make).strip()}".strip()
        return UnsuitableFileError(
            "unsupported-camera",
            f"it is a picture of a {name}, but no raw file that LibRaw reads; if it is one, convert it to DNG",
        )
    return UnreadableFileError(code, message)


def _cut_short() -> UnreadableFileError:
    return UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")


def _header(path: Path, said: Description, decoded: Decoded, *, facts: ShotFacts, coding: Coding) -> RawHeader:
    inside = decoded.visible_lies_inside
    whole = Area(0, 0, decoded.raw_height, decoded.raw_width)
    sites = decoded.pattern if len(decoded.pattern) == 4 else (0,)
    black = tuple(decoded.black[number] for number in sites)
    return RawHeader(
        path=path,
        format=path.suffix.lower().removeprefix(".") or "maker",
        raw_width=decoded.raw_width,
        raw_height=decoded.raw_height,
        active_area=decoded.visible if inside else whole,
        cfa=_order(decoded),
        bit_depth=max(1, decoded.white.bit_length()),
        black_level=Levels(values=black, source="metadata", tag="LibRaw black"),
        white_level=Levels(values=(float(decoded.white),) * len(sites), source="metadata", tag="LibRaw maximum"),
        iso=facts.iso,
        exposure_s=facts.exposure_s,
        temperature_c=facts.temperature_c,
        make=facts.make,
        model=facts.model,
        orientation=facts.orientation or _ORIENTATIONS.get(decoded.flip, 1),
        compression=coding.name,
        masked_areas=_masked(decoded) if inside else (),
        as_shot_neutral=_neutral(decoded),
        colour_matrix=_colour_matrix(decoded),
        level_tags=(
            ("LibRaw black", black),
            ("LibRaw maximum", (float(decoded.white),)),
            *((("LibRaw linear_max", decoded.linear),) if decoded.linear else ()),
            *level_tags(said.tags, make=facts.make),
        ),
        layout=MakerLayout(),
        findings=(*_refusals(said, decoded, coding), *coding.findings),
    )


def _order(decoded: Decoded) -> str | None:
    if len(decoded.pattern) == 1:
        return MONO
    order = "".join(decoded.colours[number] for number in decoded.pattern) if len(decoded.pattern) == 4 else ""
    return order if order in BAYER else None


def _neutral(decoded: Decoded) -> tuple[float, ...]:
    """Return white in the camera's own R, G and B, green 1; empty where LibRaw does not know it."""
    if _order(decoded) in {None, MONO}:
        return ()
    red, green, blue = (decoded.balance[decoded.colours.index(letter)] for letter in "RGB")
    believable = min(red, green, blue) > 0.0 and max(red, green, blue) < _MOST_COLOUR * min(red, green, blue)
    return (green / red, 1.0, green / blue) if believable else ()


def _colour_matrix(decoded: Decoded) -> ColourMatrix | None:
    believable = 0.0 < max(map(abs, decoded.matrix), default=0.0) < _MOST_COLOUR
    return ColourMatrix(decoded.matrix, D65) if believable and len(decoded.matrix) == 9 else None


def _refusals(said: Description, decoded: Decoded, coding: Coding) -> Iterator[Finding]:
    """Yield why a file must not be measured."""
    if not decoded.flat:
        yield _refusal(
            "processed-rgb",
            "it holds several colours for every pixel (sRAW, linear or layered), not a mosaic; record full raw files",
        )
    elif said.container.fuji_rotated and not decoded.visible_lies_inside:
        yield _refusal("unsupported-cfa", "its pixels stand diagonally (SuperCCD), not in rows and columns")
    elif not decoded.visible_lies_inside:
        yield _refusal("file-damaged", "its header gives no possible size; copy the file again")
    elif _order(decoded) is None:
        yield _refusal("unsupported-cfa", _pattern_sentence(decoded))
    if coding.refusal is not None:
        yield _refusal(*coding.refusal)
    elif decoded.flat and decoded.white <= _COMPANDED_WHITE:
        yield _refusal(
            "companded", "its codes have eight bits and went through a tone curve, so their noise is not the sensor's"
        )
    elif decoded.flat and decoded.longest_step > 1:
        yield _refusal(
            "companded",
            f"its codes went through a tone curve whose steps grow to {decoded.longest_step} DN, so their noise is not "
            "the sensor's; set the camera to lossless or uncompressed raw",
        )


def _refusal(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.ERROR, message=f"It cannot be measured: {message}.")


def _pattern_sentence(decoded: Decoded) -> str:
    edge = math.isqrt(len(decoded.pattern))
    if edge == 6:
        return "its colour-filter array is X-Trans (6 x 6), whose planes Fullwell does not part"
    colours = "".join(sorted({decoded.colours[one] for one in decoded.pattern if one < len(decoded.colours)}))
    if edge == 2:
        return f"its colours are {colours}, not red, green and blue in one of the four Bayer orders"
    shown = f" ({edge} x {edge}, {colours})" if edge else ""
    return f"its colour-filter array{shown} is not one of the four Bayer orders"


def _masked(decoded: Decoded) -> tuple[Area, ...]:
    """Return the margins that are dark: some makers leave pixels there that see light."""
    black = float(np.mean(decoded.black))
    return tuple(
        margin.area
        for margin in decoded.margins
        if margin.median - black <= max(_DARK_MARGIN * (margin.visible - black), _LEAST_MARGIN_DN, 0.05 * black)
    )
