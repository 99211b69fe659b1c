"""FITS, as astronomical cameras write it: the door to astropy.

The first image of two dimensions counts, in the primary part or an extension. Its values must be whole numbers from 0
to 65535 once BZERO and BSCALE are applied, however they are stored; rows are returned as they are stored.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.cfa import BAYER, MONO, shifted
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.segments import MAX_PIXELS

SIGNATURE: Final = b"SIMPLE  ="
_BLOCK: Final = 2880
_DTYPES: Final = {8: "u1", 16: ">i2", 32: ">i4", 64: ">i8", -32: ">f4", -64: ">f8"}
_HIGHEST: Final = 65535
_MOST_PARTS: Final = 64
_AMPLIFICATION: Final = ("EGAIN", "GAIN", "OFFSET", "PEDESTAL")


@dataclass(frozen=True, slots=True, kw_only=True)
class FitsLayout:
    """Where the image lies in the file and how its numbers are stored."""

    offset: int
    dtype: str
    zero: float
    scale: float


def read_fits_header(path: Path, size: int) -> RawHeader:
    """Return the header of a FITS file.

    Parameters
    ----------
    path
        The file.
    size
        Its length [byte].

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb`` where it holds no image of two dimensions, ``unsupported-compression`` where that is packed.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    with path.open("rb") as file:
        cards, offset = _image(file, size)
    width, height, bits = (_whole(cards, name) for name in ("NAXIS1", "NAXIS2", "BITPIX"))
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        raise UnreadableFileError("file-damaged", "the FITS header gives no possible size; copy the file again")
    if bits not in _DTYPES:
        raise UnreadableFileError("file-damaged", f"the FITS header gives {bits} bits per number; copy the file again")
    if offset + width * height * abs(bits) // 8 > size:
        raise UnreadableFileError("file-truncated", "the FITS file ends before its pixels do; copy it again")
    layout = FitsLayout(
        offset=offset, dtype=_DTYPES[bits], zero=_number(cards, "BZERO") or 0.0, scale=_number(cards, "BSCALE") or 1.0
    )
    return RawHeader(
        path=path,
        format="fits",
        raw_width=width,
        raw_height=height,
        active_area=Area(0, 0, height, width),
        cfa=_cfa(cards, height),
        bit_depth=8 if bits == 8 else 16,
        iso=_number(cards, "ISOSPEED") or _number(cards, "GAIN") or None,
        exposure_s=_number(cards, "EXPTIME") or _number(cards, "EXPOSURE") or None,
        temperature_c=_number(cards, "CCD-TEMP"),
        model=str(cards.get("INSTRUME", "")).strip() or None,
        level_tags=tuple((name, (value,)) for name in _AMPLIFICATION if (value := _number(cards, name)) is not None),
        layout=layout,
    )


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


def _image(file: BinaryIO, size: int) -> tuple[Any, int]:
    """Return the cards of the first image of two dimensions, and where its numbers begin [byte]."""
    from astropy.io.fits import Header  # noqa: PLC0415 - loads when used

    for _ in range(_MOST_PARTS):
        if file.tell() >= size:
            break
        try:
            cards = Header.fromfile(file)
            offset = file.tell()
            axes = [_whole(cards, f"NAXIS{n + 1}") for n in range(_whole(cards, "NAXIS"))]
            packed = bool(cards.get("ZIMAGE", False))
        except UnreadableFileError:
            raise
        except Exception as error:  # astropy's message is all there is, whatever its class
            raise UnreadableFileError("file-damaged", f"the FITS header is damaged ({error})") from error
        if packed:
            raise UnsuitableFileError("unsupported-compression", "the FITS image is packed; unpack it with funpack")
        if len(axes) == 2 and min(axes) > 0 and str(cards.get("XTENSION", "IMAGE")).strip() == "IMAGE":
            return cards, offset
        length = math.prod(axes) * abs(_whole(cards, "BITPIX")) // 8 if axes else 0
        file.seek(offset + -(-(length + _whole(cards, "PCOUNT", 0)) // _BLOCK) * _BLOCK)
    raise UnsuitableFileError("processed-rgb", "the FITS file holds no image of two dimensions")


def _cfa(cards: Any, height: int) -> str | None:  # noqa: ANN401 - astropy has no types
    """Return the order at the first stored pixel: ``BAYERPAT`` counts from the picture's top, wherever that lies."""
    pattern = str(cards.get("BAYERPAT", "")).strip().upper()
    if not pattern:
        return None
    if pattern not in BAYER:
        return MONO if pattern in {"MONO", "NONE"} else None
    rows, columns = (_whole(cards, name, 0) for name in ("YBAYROFF", "XBAYROFF"))
    bottom_up = str(cards.get("ROWORDER", "")).strip().upper() == "BOTTOM-UP"
    return shifted(pattern, rows=rows + (height - 1 if bottom_up else 0), columns=columns)


def _number(cards: Any, name: str) -> float | None:  # noqa: ANN401 - astropy has no types
    try:
        value = float(cards.get(name))
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def _whole(cards: Any, name: str, default: int | None = None) -> int:  # noqa: ANN401 - astropy has no types
    value = _number(cards, name)
    if value is None:
        if default is None:
            raise UnreadableFileError("file-damaged", f"the FITS header lacks {name}; copy the file again")
        return default
    return int(value)
