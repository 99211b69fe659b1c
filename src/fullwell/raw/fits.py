"""FITS, as astronomical cameras write it: the door to astropy.

The first image of two dimensions counts, in the primary part or an extension; without one, the planes of the first of
three are frames, unless they are three or four, which may be colours. Values must be whole numbers from 0 to 65535 once
BZERO and BSCALE are applied, however they are stored; rows are returned as they are stored.
"""

import math
import threading
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import BAYER, MONO, shifted
from fullwell.raw.image import Area, Levels, RawHeader
from fullwell.raw.pages import MAX_FRAMES, paged
from fullwell.raw.segments import MAX_PIXELS

SIGNATURE: Final = b"SIMPLE  ="
_BLOCK: Final = 2880
_DTYPES: Final = {8: "u1", 16: ">i2", 32: ">i4", 64: ">i8", -32: ">f4", -64: ">f8"}
_HIGHEST: Final = 65535
_MOST_PARTS: Final = 64
_MOST_AXES: Final = 8
_QUIET: Final = threading.Lock()
"""Filters of warnings belong to the whole process: one thread at a time sets them."""
_COLOURS: Final = (3, 4)
_AMPLIFICATION: Final = ("EGAIN", "GAIN", "OFFSET", "BLKLEVEL", "PEDESTAL", "DATAMAX", "SATLEVEL")
_SETTINGS: Final = ("EGAIN", "GAIN", "OFFSET", "BLKLEVEL")
_BLACK: Final = ("BLKLEVEL",)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitsLayout:
    """Where the image lies in the file and how its numbers are stored."""

    offset: int
    dtype: str
    zero: float
    scale: float


def read_fits_headers(path: Path, size: int) -> tuple[RawHeader, ...]:
    """Return the header of every frame of a FITS file.

    Parameters
    ----------
    path
        The file.
    size
        Its length [byte].

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where it holds no image of two dimensions, or one of three or four planes;
        ``unsupported-compression`` where the image is packed.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    with _QUIET, warnings.catch_warnings(), path.open("rb") as file:
        warnings.simplefilter("ignore")  # astropy warns of what it mends, some of it only when a card is read
        cards, offset, others = _image(file, size)
        return _headers(path, cards, offset, size=size, others=others)


def _headers(path: Path, cards: Any, offset: int, *, size: int, others: int) -> tuple[RawHeader, ...]:  # noqa: ANN401 - astropy has no types
    width, height, bits = (_whole(cards, name) for name in ("NAXIS1", "NAXIS2", "BITPIX"))
    frames = _whole(cards, "NAXIS3", 1) if _whole(cards, "NAXIS") == 3 else 1
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS and 0 < frames <= MAX_FRAMES):
        raise UnreadableFileError("file-damaged", "the FITS header gives no possible size; copy the file again")
    if bits not in _DTYPES:
        raise UnreadableFileError("file-damaged", f"the FITS header gives {bits} bits per number; copy the file again")
    length = width * height * abs(bits) // 8
    if offset + frames * length > size:
        raise UnreadableFileError("file-truncated", "the FITS file ends before its pixels do; copy it again")
    layout = FitsLayout(
        offset=offset, dtype=_DTYPES[bits], zero=_number(cards, "BZERO") or 0.0, scale=_number(cards, "BSCALE") or 1.0
    )
    whole = _header(path, cards, layout=layout, others=others)
    return paged(whole, frames=frames, offset=offset, length=length, layout=replace(layout, offset=0))


def _header(path: Path, cards: Any, *, layout: FitsLayout, others: int) -> RawHeader:  # noqa: ANN401 - astropy has no types
    width, height = _whole(cards, "NAXIS1"), _whole(cards, "NAXIS2")
    message = f"One of {others + 1} images in the FITS file is read; split the file where the others count."
    left_out = Finding(code="images-left-out", severity=Severity.WARNING, message=message)
    pedestal = next((value for name in _BLACK if (value := _number(cards, name))), None)
    return RawHeader(
        path=path,
        format="fits",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=_cfa(cards, height),
        bit_depth=8 if layout.dtype == "u1" else 16,
        black_level=None if pedestal is None else _levels(cards, pedestal, height=height),
        iso=_number(cards, "ISOSPEED") or _number(cards, "GAIN") or None,
        exposure_s=_number(cards, "EXPTIME") or _number(cards, "EXPOSURE") or None,
        temperature_c=_first(cards, "CCD-TEMP", "DET-TEMP", "SET-TEMP"),
        make=_text(cards, "MAKE"),
        model=_text(cards, "INSTRUME") or _text(cards, "CAMERA"),
        level_tags=tuple((name, (value,)) for name in _AMPLIFICATION if (value := _number(cards, name)) is not None),
        settings=_settings(cards),
        layout=layout,
        findings=(left_out,) if others else (),
    )


def _levels(cards: Any, pedestal: float, *, height: int) -> Levels:  # noqa: ANN401 - astropy has no types
    sites = 1 if _cfa(cards, height) in {None, MONO} else 4
    return Levels(values=(pedestal,) * sites, source="metadata", tag="BLKLEVEL")


def _settings(cards: Any) -> str:  # noqa: ANN401 - astropy has no types
    """Return what sets amplification and offset, as far as no ISO tells it."""
    numbers = [f"{name} {value:.4g}" for name in _SETTINGS if (value := _number(cards, name)) is not None]
    mode = _text(cards, "READOUTM")
    return ", ".join((*numbers, *((f"READOUTM {mode}",) if mode else ())))


def decode_fits(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of a FITS file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated``.
    UnsuitableFileError
        ``unsupported-sample-format`` where a value is not a whole number from 0 to 65535.

    """
    layout = header.layout
    if not isinstance(layout, FitsLayout):
        raise TypeError("the header is not that of a FITS file")
    count = header.raw_width * header.raw_height
    dtype = np.dtype(layout.dtype)
    if layout.offset + count * dtype.itemsize > len(data):
        raise UnreadableFileError("file-truncated", "the FITS file ends before its pixels do; copy it again")
    stored = np.frombuffer(data, dtype, count, layout.offset).reshape(header.raw_height, header.raw_width)
    if dtype.str == ">i2" and (layout.zero, layout.scale) == (32768.0, 1.0):
        mosaic = stored.view(">u2").astype(np.uint16) ^ np.uint16(0x8000)
    else:
        with np.errstate(all="ignore"):  # what is not finite is refused
            mosaic = _whole_codes(stored * layout.scale + layout.zero)
    area = header.active_area
    return np.ascontiguousarray(mosaic[area.top : area.bottom, area.left : area.right])


def _whole_codes(values: NDArray[Any]) -> NDArray[np.uint16]:
    whole = np.rint(values)
    if not bool(np.all(np.isfinite(values) & (whole == values) & (values >= 0.0) & (values <= _HIGHEST))):
        raise UnsuitableFileError(
            "unsupported-sample-format",
            "its values are not whole numbers from 0 to 65535: calibrated or stacked frames cannot be measured, give "
            "the camera's own",
        )
    return whole.astype(np.uint16)


def _image(file: BinaryIO, size: int) -> tuple[Any, int, int]:
    """Return the cards of the image that counts, where its numbers begin [byte], and how many others there are."""
    images: list[tuple[int, int, Any, int]] = []
    first: Any = None
    for place, (cards, axes) in enumerate(_parts(file, size)):
        if place == 0 and not axes:
            first = cards
        if 2 <= len(axes) <= 3 and min(axes) > 0 and _text(cards, "XTENSION") in {None, "IMAGE"}:
            images.append((len(axes), place, cards, file.tell()))
    if not images:
        raise UnsuitableFileError("processed-rgb", "the FITS file holds no image of two dimensions")
    dimensions, _place, cards, offset = min(images, key=lambda one: one[:2])
    if dimensions == 3 and (planes := _whole(cards, "NAXIS3")) in _COLOURS:
        raise UnsuitableFileError(
            "processed-rgb",
            f"the FITS image has {planes} planes, which may be colours or frames; save one frame a file",
        )
    return _inherited(cards, first), offset, len(images) - 1


def _inherited(cards: Any, first: Any) -> Any:  # noqa: ANN401 - astropy has no types
    """Return an extension's cards, and those of a primary part without an image where it has none of its own.

    An extension whose INHERIT is F takes none.
    """
    if first is None or cards.get("INHERIT", True) is False:
        return cards
    try:
        cards.extend(first, strip=True, unique=True)
    except Exception as error:  # astropy's message is all there is, whatever its class
        raise UnreadableFileError("file-damaged", f"the FITS header is damaged ({error})") from error
    return cards


def _parts(file: BinaryIO, size: int) -> Iterator[tuple[Any, list[int]]]:
    """Yield the cards and axes of each part of a file, which then stands at the part's numbers."""
    from astropy.io.fits import Header  # noqa: PLC0415 - loads when used

    for _ in range(_MOST_PARTS):
        if file.tell() >= size:
            return
        try:
            cards = Header.fromfile(file)
            offset = file.tell()
            axes = [_whole(cards, f"NAXIS{n + 1}") for n in range(min(_whole(cards, "NAXIS"), _MOST_AXES))]
            packed = bool(cards.get("ZIMAGE", False))
        except UnreadableFileError:
            raise
        except Exception as error:  # astropy's message is all there is, whatever its class
            raise UnreadableFileError("file-damaged", f"the FITS header is damaged ({error})") from error
        if packed:
            raise UnsuitableFileError("unsupported-compression", "the FITS image is packed; unpack it with funpack")
        yield cards, axes
        length = math.prod(axes) * abs(_whole(cards, "BITPIX")) // 8 if axes else 0
        start = offset + -(-(length + _whole(cards, "PCOUNT", 0)) // _BLOCK) * _BLOCK
        if not offset <= start < size:
            return
        file.seek(start)


def _cfa(cards: Any, height: int) -> str | None:  # noqa: ANN401 - astropy has no types
    """Return the order at the first stored pixel: ``BAYERPAT`` counts from the picture's top, wherever that lies."""
    pattern = (_text(cards, "BAYERPAT") or _text(cards, "COLORTYP") or "").upper()
    if not pattern:
        return None
    if pattern not in BAYER:
        return MONO if pattern in {"MONO", "NONE"} else None
    rows, columns = (_whole(cards, name, 0) for name in ("YBAYROFF", "XBAYROFF"))
    bottom_up = (_text(cards, "ROWORDER") or "").upper() == "BOTTOM-UP"
    return shifted(pattern, rows=rows + (height - 1 if bottom_up else 0), columns=columns)


def _text(cards: Any, name: str) -> str | None:  # noqa: ANN401 - astropy has no types
    try:
        value = cards.get(name)
    except Exception:  # noqa: BLE001 - astropy's errors are many, and all mean that the card is damaged
        return None
    return value.strip() or None if isinstance(value, str) else None


def _first(cards: Any, *names: str) -> float | None:  # noqa: ANN401 - astropy has no types
    return next((value for name in names if (value := _number(cards, name)) is not None), None)


def _number(cards: Any, name: str) -> float | None:  # noqa: ANN401 - astropy has no types
    try:
        value = float(cards.get(name))
    except Exception:  # noqa: BLE001 - astropy's errors are many, and all mean that the card is damaged
        return None
    return value if math.isfinite(value) else None


def _whole(cards: Any, name: str, default: int | None = None) -> int:  # noqa: ANN401 - astropy has no types
    value = _number(cards, name)
    if value is None:
        if default is None:
            raise UnreadableFileError("file-damaged", f"the FITS header lacks {name}; copy the file again")
        return default
    return int(value)
