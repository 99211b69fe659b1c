"""How a frame was taken and which levels it declares, by the tags of its maker."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from fullwell.raw.description import Description
from fullwell.raw.exif import CAMERA_TEMPERATURE, COLOR_DATA, ExifTags
from fullwell.raw.tags import ISO_IN_OTHER_TAG, ISO_TAGS, Tag

_CANON_SHOT_INFO: Final = 0x0004
_PENTAX_TEMPERATURE: Final = 0x0047
_PLACES: Final = ("EXIF", "Image")

_LEVELS: Final = (
    ("", "EXIF SubIFD", Tag.BLACK_LEVEL, "BlackLevel"),
    ("", "EXIF SubIFD", Tag.WHITE_LEVEL, "WhiteLevel"),
    ("", "Image", Tag.BLACK_LEVEL, "BlackLevel"),
    ("", "Image", Tag.WHITE_LEVEL, "WhiteLevel"),
    ("nikon", "MakerNote", 0x003D, "BlackLevel"),
    ("sony", "EXIF SubIFD", 0x7310, "BlackLevel"),
    ("sony", "EXIF SubIFD", 0x787F, "WhiteLevel"),
    ("pentax", "MakerNote", 0x0200, "BlackPoint"),
    ("pentax", "MakerNote", 0x0201, "WhitePoint"),
    ("ricoh", "MakerNote", 0x0200, "BlackPoint"),
    ("ricoh", "MakerNote", 0x0201, "WhitePoint"),
    ("olympus", "MakerNote", 0x1012, "BlackLevel"),
    *(
        ("panasonic", "Image", number, name)
        for number, name in (
            (0x0E, "LinearityLimitRed"), (0x0F, "LinearityLimitGreen"), (0x10, "LinearityLimitBlue"),
            (0x1C, "BlackLevelRed"), (0x1D, "BlackLevelGreen"), (0x1E, "BlackLevelBlue"),
        )
    ),
)  # fmt: skip
"""Maker, directory, number and the maker's own name of a level tag."""

_CANON_LEVELS: Final = (
    ((674, 692, 702, 1227, 1250, 1251, 1337, 1338, 1346), (4, 5), 0x2B4, 0x2B8),
    ((674, 692, 702, 1227, 1250, 1251, 1337, 1338, 1346), (6, 7), 0x2CB, 0x2CF),
    ((674, 692, 702, 1227, 1250, 1251, 1337, 1338, 1346), (9,), 0x2CF, 0x2D3),
    ((1273, 1275), (), 0x1DF, 0x1E3),
    ((1312, 1313, 1316, 1506), (10,), 0x1F8, 0x1FC),
    ((1312, 1313, 1316, 1506), (11,), 0x2D8, 0x2DC),
    ((1560, 1592, 1353, 1602), (14,), 0x22C, 0x230),
    ((1560, 1592, 1353, 1602), (12, 13, 15), 0x30A, 0x30E),
    ((1816, 1820, 1824), (), 0x149, 0x31C),
    ((2024, 3656), (), 0x157, 0x32A),
    ((3973, 3778), (34,), 0x16B, 0x280),
)
"""Canon's ColorData by its length and version (none: any): where the black levels stand, and the white ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotFacts:
    """How a frame was taken; None where the file does not say, or says 0.

    Parameters
    ----------
    iso
        ISO speed [1].
    exposure_s
        Exposure time [s].
    temperature_c
        Of the camera or its sensor [deg C].
    make, model
        As the maker writes them.
    orientation
        TIFF tag Orientation.

    """

    iso: float | None
    exposure_s: float | None
    temperature_c: float | None
    make: str | None
    model: str | None
    orientation: int | None


def shot_facts(said: Description) -> ShotFacts:
    """Return how a frame was taken: by its EXIF tags, by LibRaw where it has none."""
    tags, decoded = said.tags, said.decoded
    isos = [tags.number(tag, *_PLACES) for tag in ISO_TAGS]
    known = [iso for iso in isos if iso is not None and 0 < iso != ISO_IN_OTHER_TAG]
    exposure = tags.number(Tag.EXPOSURE_TIME, *_PLACES)
    orientation = tags.number(Tag.ORIENTATION, "Image")
    return ShotFacts(
        iso=known[0] if known else (None if decoded is None else decoded.iso or None),
        exposure_s=exposure if exposure and exposure > 0 else (None if decoded is None else decoded.exposure_s or None),
        temperature_c=_temperature(tags),
        make=tags.text(Tag.MAKE, "Image", "Thumbnail") or said.container.make,
        model=tags.text(Tag.MODEL, "Image", "Thumbnail") or said.container.model,
        orientation=int(orientation) if orientation is not None and 1 <= orientation <= 8 else None,
    )


def level_tags(tags: ExifTags, *, make: str | None) -> tuple[tuple[str, tuple[float, ...]], ...]:
    """Return every level the file declares, by its maker's own name."""
    maker = (make or "").casefold()
    found = [
        (name, values)
        for start, directory, number, name in _LEVELS
        if maker.startswith(start) and (values := tags.numbers(number, directory)) and all(map(math.isfinite, values))
    ]
    return (*found, *(_canon_levels(tags) if maker.startswith("canon") else ()))


def _canon_levels(tags: ExifTags) -> Iterator[tuple[str, tuple[float, ...]]]:
    table = tags.numbers(COLOR_DATA, "MakerNote")
    for lengths, versions, black, white in _CANON_LEVELS:
        if len(table) in lengths and (not versions or table[0] in versions):
            yield "PerChannelBlackLevel", table[black : black + 4]
            yield "NormalWhiteLevel", table[white : white + 1]
            yield "SpecularWhiteLevel", table[white + 1 : white + 2]
            return


def _temperature(tags: ExifTags) -> float | None:
    ambient = tags.number(Tag.TEMPERATURE, "EXIF")
    if ambient is not None:
        return ambient
    maker = (tags.text(Tag.MAKE, "Image") or "").casefold()
    if maker.startswith("canon"):
        return _canon_temperature(tags)
    return tags.number(_PENTAX_TEMPERATURE, "MakerNote") if maker.startswith(("pentax", "ricoh")) else None


def _canon_temperature(tags: ExifTags) -> float | None:
    """Return what ShotInfo says: stored as degrees plus 128, and 0 where the camera does not tell."""
    said = re.match(r"(-?\d+) C", tags.text(CAMERA_TEMPERATURE, "MakerNote") or "")
    if said is not None:
        return float(said[1]) if said[1] not in {"0", "-128"} else None
    stored = tags.numbers(_CANON_SHOT_INFO, "MakerNote")
    return stored[12] - 128.0 if len(stored) > 12 and stored[12] > 0 else None


def stored_end(tags: ExifTags) -> int:
    """Return where the largest picture that the directories name ends in the file; 0 where they name none [byte]."""
    found: list[tuple[float, float]] = []
    for place in sorted({place for place, number, _values in tags.entries if number == Tag.STRIP_BYTE_COUNTS}):
        offsets, sizes = (tags.numbers(tag, place) for tag in (Tag.STRIP_OFFSETS, Tag.STRIP_BYTE_COUNTS))
        found += [(size, offset + size) for offset, size in zip(offsets, sizes, strict=False)]
    return int(max(found)[1]) if found else 0
