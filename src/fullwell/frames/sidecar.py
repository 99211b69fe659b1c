"""JSON sidecars: what a camera's software wrote beside a frame, by GenICam names (RESULTS 1).

A sidecar has the stem of its frame. It may nest its values: ``selected_settings`` is preferred, then the top level,
then any depth where the name occurs with one value only. `read_sidecar` reads one, `completed` adds what it says to
what the frame says for itself.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UnreadableFileError
from fullwell.frames.series import CONTAINER_BITS
from fullwell.raw.cfa import MONO, cell
from fullwell.raw.headerless_format import BYTE, LSB, WORD, HeaderlessFormat
from fullwell.raw.image import Levels, RawHeader

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
    black_level, white_level
        ``BlackLevel`` and ``WhiteLevel``, which GenICam lacks: a number, or one per CFA site, row by row [DN].
    iso
        ``ISO``, which GenICam lacks.
    make, model
        ``DeviceVendorName`` and ``DeviceModelName``.
    noise_profile, as_shot_neutral
        ``NoiseProfile`` and ``AsShotNeutral``, as the DNG tags of these names; empty where absent.
    headerless
        From ``Width``, ``Height`` and ``PixelFormat``: how the frame is stored if it has no header.

    """

    exposure_s: float | None = None
    temperature_c: float | None = None
    cfa: str | None = None
    bit_depth: int | None = None
    black_level: tuple[float, ...] | None = None
    white_level: tuple[float, ...] | None = None
    iso: float | None = None
    make: str | None = None
    model: str | None = None
    noise_profile: tuple[tuple[float, float], ...] = ()
    as_shot_neutral: tuple[float, ...] = ()
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
        black_level=_numbers(_find(settings, "BlackLevel"), counts=(1, 4)) or None,
        white_level=_numbers(_find(settings, "WhiteLevel"), counts=(1, 4)) or None,
        iso=_positive(_find(settings, "ISO")),
        make=_text(_find(settings, "DeviceVendorName")),
        model=_text(_find(settings, "DeviceModelName")),
        noise_profile=_pairs(_find(settings, "NoiseProfile")),
        as_shot_neutral=_neutral(_find(settings, "AsShotNeutral")),
        headerless=_headerless(settings),
    )


def completed(header: RawHeader, facts: SidecarFacts) -> RawHeader:
    """Return a header with what its sidecar says where the file itself says nothing.

    Levels per site go with a Bayer mosaic only. The bit depth is the sidecar's where the file tells its container's
    alone.

    Examples
    --------
    >>> from fullwell.raw.image import Area
    >>> bare = RawHeader(
    ...     path=Path("a.tif"),
    ...     format="tiff",
    ...     raw_width=4,
    ...     raw_height=2,
    ...     active_area=Area(0, 0, 2, 4),
    ...     cfa=None,
    ...     bit_depth=16,
    ... )
    >>> whole = completed(bare, SidecarFacts(cfa="mono", bit_depth=12, black_level=(10.0,), iso=100.0))
    >>> whole.cfa, whole.bit_depth, whole.black_level.values, whole.iso, whole.exposure_s
    ('mono', 12, (10.0,), 100.0, None)

    """
    cfa = header.cfa or facts.cfa
    return replace(
        header,
        cfa=cfa,
        bit_depth=facts.bit_depth or CONTAINER_BITS if header.bit_depth == CONTAINER_BITS else header.bit_depth,
        black_level=header.black_level or _levels(facts.black_level, "BlackLevel", cfa=cfa),
        white_level=header.white_level or _levels(facts.white_level, "WhiteLevel", cfa=cfa),
        iso=header.iso if header.iso is not None else facts.iso,
        exposure_s=header.exposure_s if header.exposure_s is not None else facts.exposure_s,
        temperature_c=header.temperature_c if header.temperature_c is not None else facts.temperature_c,
        make=header.make or facts.make,
        model=header.model or facts.model,
        noise_profile=header.noise_profile or facts.noise_profile,
        as_shot_neutral=header.as_shot_neutral or facts.as_shot_neutral,
    )


def _levels(values: tuple[float, ...] | None, tag: str, *, cfa: str | None) -> Levels | None:
    sites = len(values or ()) if cfa is None else cell(cfa) ** 2
    if values is None or len(values) not in {1, sites}:
        return None
    return Levels(values=values if len(values) == sites else values * sites, source="sidecar", tag=tag)


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


def _positive(value: object) -> float | None:
    number = _number(value)
    return number if number is not None and number > 0.0 else None


def _text(value: object) -> str | None:
    return value.strip() or None if isinstance(value, str) else None


def _numbers(value: object, *, counts: tuple[int, ...]) -> tuple[float, ...]:
    """Return a number, or a list of so many of them; empty where it is neither."""
    listed = cast("list[object]", value) if isinstance(value, list) else [value]
    numbers = [_number(one) for one in listed]
    known = tuple(number for number in numbers if number is not None)
    return known if len(known) == len(listed) and len(listed) in counts else ()


def _pairs(value: object) -> tuple[tuple[float, float], ...]:
    rows = [_numbers(row, counts=(2,)) for row in cast("list[object]", value)] if isinstance(value, list) else []
    return tuple((row[0], row[1]) for row in rows) if all(rows) else ()


def _neutral(value: object) -> tuple[float, ...]:
    numbers = _numbers(value, counts=(3,))
    return numbers if all(number > 0.0 for number in numbers) else ()


def _pixel_format(value: object) -> tuple[str | None, int | None]:
    match = _PIXEL_FORMAT.match(value) if isinstance(value, str) else None
    if match is None:
        return None, None
    cfa = next(cfa for cfa, name in PIXEL_FORMATS.items() if name.lower() == match[1].lower())
    return cfa, int(match[2]) if match[2] else None
