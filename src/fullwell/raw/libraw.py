"""Maker raw files as LibRaw reads them: the door to rawpy.

What LibRaw says of a file is taken with care: its mosaic, its margins and its order of colours; the margins are handed
on as masked areas, so that the black level can be measured rather than believed.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.image import Area, Levels, RawHeader
from fullwell.raw.segments import MAX_PIXELS

if TYPE_CHECKING:
    import rawpy

SUFFIXES: Final = frozenset(
    {
        ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".erf", ".fff", ".iiq", ".kdc", ".mef", ".mos", ".mrw", ".nef",
        ".nrw", ".orf", ".pef", ".raf", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f",
    }
)  # fmt: skip
"""Endings of files that are handed to LibRaw."""

_COLOURS: Final = "RGBG"
_LEAST_MARGIN: Final = 4
"""Rows or columns of a margin below which it is no optical black [pixel]."""

_COMPANDED_WHITE: Final = 255
"""A maker raw of eight bits has been through a tone curve: sensors have more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LibRawImage:
    """What LibRaw says of a raw file, in Fullwell's order of sites.

    Parameters
    ----------
    mosaic
        Visible mosaic, ``uint16``, shape (height, width) [DN].
    cfa
        Order at the visible top-left pixel, or ``mono``.
    black_level
        Per site, row-major, as whole numbers: LibRaw rounds [DN].
    white_level
        [DN].
    iso, exposure_s
        None where LibRaw says 0.

    """

    mosaic: NDArray[np.uint16]
    cfa: str
    black_level: tuple[float, ...]
    white_level: float
    iso: float | None
    exposure_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LibRawLayout:
    """Marks a header whose pixels LibRaw decodes."""


def read_maker_header(path: Path) -> RawHeader:
    """Return the header of a maker's raw file.

    Raises
    ------
    UnreadableFileError
        ``not-a-raw-file`` or ``file-damaged`` where LibRaw does not open it.
    UnsuitableFileError
        ``processed-rgb`` where it is no mosaic, ``unsupported-cfa`` where that is not one of the four Bayer orders,
        ``companded`` where its codes went through a tone curve.

    """
    import rawpy  # noqa: PLC0415 - loads when used

    raw = rawpy.RawPy()
    try:
        raw.open_file(str(path))
        return _header(raw, path)
    except rawpy.LibRawError as error:
        raise _unreadable(error) from error
    finally:
        raw.close()


def decode_maker(header: RawHeader, data: memoryview) -> NDArray[np.uint16]:
    """Return the visible mosaic of a maker's raw file, shape (height, width) [DN].

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where LibRaw does not decode it, or finds another size than its header told.

    """
    import rawpy  # noqa: PLC0415 - loads when used

    try:
        with rawpy.imread(io.BytesIO(data)) as raw:
            stored = np.asarray(raw.raw_image)
            if stored.shape != (header.raw_height, header.raw_width):
                raise UnreadableFileError("file-damaged", "its pixels are not the size its header says; copy it again")
            area = header.active_area
            return np.array(stored[area.top : area.bottom, area.left : area.right], dtype=np.uint16)
    except rawpy.LibRawError as error:
        raise _unreadable(error) from error


def read_with_libraw(path: Path) -> LibRawImage:
    """Return a raw file as LibRaw decodes it, whatever reader of ours there is for it.

    Raises
    ------
    UnreadableFileError
        ``not-a-raw-file`` where LibRaw does not open it.

    """
    import rawpy  # noqa: PLC0415 - loads when used

    try:
        with rawpy.imread(str(path)) as raw:
            numbers = _numbers(raw)
            return LibRawImage(
                mosaic=np.array(raw.raw_image_visible, dtype=np.uint16),
                cfa="".join(_COLOURS[number] for number in numbers) if len(numbers) == 4 else MONO,
                black_level=tuple(float(raw.black_level_per_channel[number]) for number in numbers),
                white_level=float(raw.white_level),
                iso=float(raw.other.iso_speed) or None,
                exposure_s=float(raw.other.shutter_speed) or None,
            )
    except rawpy.LibRawError as error:
        raise UnreadableFileError("not-a-raw-file", f"LibRaw does not read it ({error})") from error


def _numbers(raw: "rawpy.RawPy") -> list[int]:
    """Return the colour number of each site, one for a monochrome sensor.

    LibRaw numbers its colours R, G1, B, G2 = 0, 1, 2, 3 with G1 and G2 wherever they fall, lists black levels by
    that number, and its ``raw_pattern`` counts from the visible top-left pixel.
    """
    pattern = raw.raw_pattern
    return [0] if pattern is None or pattern.size != 4 else [int(number) for number in pattern.ravel()]


def _header(raw: "rawpy.RawPy", path: Path) -> RawHeader:
    sizes, numbers = raw.sizes, _numbers(raw)
    _require_mosaic(raw, numbers)
    area = Area(sizes.top_margin, sizes.left_margin, sizes.top_margin + sizes.height, sizes.left_margin + sizes.width)
    inside = 0 < area.bottom <= sizes.raw_height and 0 < area.right <= sizes.raw_width
    if not inside or sizes.raw_height * sizes.raw_width > MAX_PIXELS:
        raise UnreadableFileError("file-damaged", "its header gives no possible size; copy the file again")
    white = float(raw.white_level)
    black = tuple(float(raw.black_level_per_channel[number]) for number in numbers)
    return RawHeader(
        path=path,
        format=path.suffix.lower().removeprefix("."),
        raw_width=sizes.raw_width,
        raw_height=sizes.raw_height,
        active_area=area,
        cfa=_cfa(numbers),
        bit_depth=max(1, int(white).bit_length()),
        black_level=Levels(values=black, source="metadata", tag="LibRaw black"),
        white_level=Levels(values=(white,) * len(black), source="metadata", tag="LibRaw maximum"),
        iso=float(raw.other.iso_speed) or None,
        exposure_s=float(raw.other.shutter_speed) or None,
        compression="libraw",
        masked_areas=_margins(area, sizes.raw_height, sizes.raw_width),
        level_tags=(("LibRaw black", black), ("LibRaw maximum", (white,))),
        layout=LibRawLayout(),
    )


def _require_mosaic(raw: "rawpy.RawPy", numbers: list[int]) -> None:
    import rawpy  # noqa: PLC0415 - loads when used

    if raw.raw_type != rawpy.RawType.Flat:
        raise UnsuitableFileError(
            "processed-rgb", "it holds colours for every pixel, not a mosaic (sRAW or linear); record full raw files"
        )
    pattern = raw.raw_pattern
    if pattern is not None and pattern.size > 4:
        raise UnsuitableFileError("unsupported-cfa", "its colour-filter array is not one of the four Bayer orders")
    if float(raw.white_level) <= _COMPANDED_WHITE:
        raise UnsuitableFileError(
            "companded", "its codes have eight bits and went through a tone curve, so their noise is not the sensor's"
        )
    if len(numbers) == 4 and _cfa(numbers) is None:
        raise UnsuitableFileError("unsupported-cfa", "its colour-filter array is not one of the four Bayer orders")


def _cfa(numbers: list[int]) -> str | None:
    if len(numbers) == 1:
        return MONO
    order = "".join(_COLOURS[number] for number in numbers)
    return order if order in BAYER else None


def _margins(area: Area, height: int, width: int) -> tuple[Area, ...]:
    """Return the margins beside the visible area that are wide enough to be optical black."""
    sides = (
        Area(0, area.left, area.top, area.right),
        Area(area.top, 0, area.bottom, area.left),
        Area(area.bottom, area.left, height, area.right),
        Area(area.top, area.right, area.bottom, width),
    )
    return tuple(
        side for side in sides if side.bottom - side.top >= _LEAST_MARGIN and side.right - side.left >= _LEAST_MARGIN
    )


def _unreadable(error: Exception) -> UnreadableFileError:
    return UnreadableFileError("file-damaged", f"LibRaw does not read it ({error}); copy the file again")
