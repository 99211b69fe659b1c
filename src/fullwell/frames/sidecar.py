"""JSON sidecars: what a camera's software wrote beside a frame, by GenICam names (RESULTS 1).

A sidecar has the stem of its frame. It may nest its values: ``selected_settings`` is preferred, then the top level,
then any depth where the name occurs with one value only.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UnreadableFileError
from fullwell.raw.cfa import MONO
from fullwell.raw.headerless_format import BYTE, LSB, WORD, HeaderlessFormat

_PIXEL_FORMAT: Final = re.compile(r"(Mono|Bayer(?:RG|GR|GB|BG))(\d+)?(?!\d)", re.IGNORECASE)
PIXEL_FORMATS: Final = {"RGGB": "BayerRG", "GRBG": "BayerGR", "GBRG": "BayerGB", "BGGR": "BayerBG", MONO: "Mono"}
"""GenICam's name of each CFA; the bits follow it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SidecarFacts:
    """What a sidecar says; None where it does not.

    Parameters
    ----------
    exposure_s
        From ``ExposureTime``, which GenICam gives in microseconds [s].
    temperature_c
        ``DeviceTemperature`` [degree Celsius].
    cfa, bit_depth
        From ``PixelFormat``: ``Mono12``, ``BayerRG10p``, ...
    black_level
        ``BlackLevel`` [DN].
    headerless
        From ``Width``, ``Height`` and ``PixelFormat``: how the frame is stored if it has no header.

    """

    exposure_s: float | None = None
    temperature_c: float | None = None
    cfa: str | None = None
    bit_depth: int | None = None
    black_level: float | None = None
    headerless: HeaderlessFormat | None = None


def sidecar_of(frame: Path) -> Path | None:
    """Return the sidecar of a frame, None where there is none."""
    path = frame.with_suffix(".json")
    return path if path.is_file() else None


def read_sidecar(path: Path) -> SidecarFacts:
    """Read what a sidecar says about its frame.

    Raises
    ------
    UnreadableFileError
        ``sidecar-unreadable`` where the file cannot be read or is no JSON object.

    """
    try:
        document = cast("object", json.loads(path.read_bytes()))
    except (OSError, ValueError, RecursionError) as error:
        raise UnreadableFileError("sidecar-unreadable", f"The sidecar cannot be read: {error}.") from error
    if not isinstance(document, dict):
        raise UnreadableFileError("sidecar-unreadable", "The sidecar is not a JSON object.")
    settings = cast("Mapping[str, object]", document)
    cfa, bit_depth = _pixel_format(_find(settings, "PixelFormat"))
    exposure_us = _number(_find(settings, "ExposureTime"))
    return SidecarFacts(
        exposure_s=exposure_us / 1e6 if exposure_us is not None and exposure_us > 0.0 else None,
        temperature_c=_number(_find(settings, "DeviceTemperature")),
        cfa=cfa,
        bit_depth=bit_depth,
        black_level=_number(_find(settings, "BlackLevel")),
        headerless=_headerless(settings),
    )


def _headerless(settings: Mapping[str, object]) -> HeaderlessFormat | None:
    """Return how GenICam's PixelFormat stores a frame: ``Mono12`` in words, ``Mono12p`` first bit lowest."""
    stated = _find(settings, "PixelFormat")
    cfa, bits = _pixel_format(stated)
    width, height = (_number(_find(settings, name)) for name in ("Width", "Height"))
    if bits is None or not 1 <= bits <= 16 or width is None or height is None:
        return None
    packing = _PIXEL_FORMAT.sub("", str(stated), count=1)
    container = {"": BYTE if bits <= 8 else WORD, "p": LSB}.get(packing)
    if container is None or min(width, height) < 1 or not (width.is_integer() and height.is_integer()):
        return None
    return HeaderlessFormat(width=int(width), height=int(height), bits=bits, container=container, cfa=cfa)


def _find(settings: Mapping[str, object], key: str) -> object:
    selected = settings.get("selected_settings")
    if isinstance(selected, dict) and key in selected:
        return cast("Mapping[str, object]", selected)[key]
    if key in settings:
        return settings[key]
    found = list(_anywhere(settings, key))
    return found[0] if found and all(value == found[0] for value in found) else None


def _anywhere(node: object, key: str) -> Iterator[object]:
    if isinstance(node, dict):
        for name, value in cast("Mapping[str, object]", node).items():
            if name == key:
                yield value
            else:
                yield from _anywhere(value, key)
    elif isinstance(node, list):
        for value in cast("list[object]", node):
            yield from _anywhere(value, key)


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _pixel_format(value: object) -> tuple[str | None, int | None]:
    match = _PIXEL_FORMAT.match(value) if isinstance(value, str) else None
    if match is None:
        return None, None
    cfa = next(cfa for cfa, name in PIXEL_FORMATS.items() if name.lower() == match[1].lower())
    return cfa, int(match[2]) if match[2] else None
