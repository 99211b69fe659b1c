"""What LibRaw makes of a raw file: the door to rawpy.

What LibRaw says is taken with care: its mosaic, its margins and its order of colours. It runs in a process of its own
(`fullwell.raw.isolation`), where a damaged file can do no harm; nothing here imports rawpy into the caller's.
"""

import io
import math
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError
from fullwell.raw.description import Container, Decoded, Description, Margin
from fullwell.raw.embedded import ciff_names, declared_end, fuji_is_lossy, fuji_is_rotated, wavelet_levels
from fullwell.raw.exif import read_exif
from fullwell.raw.image import Area

if TYPE_CHECKING:
    import rawpy

_LEAST_MARGIN: Final = 4
"""Rows or columns of a margin below which nothing is said of it [pixel]."""


def describe(data: bytes) -> tuple[Mapping[str, Any], None]:
    """Return the `Description` of a file as JSON has it; in the process of the decoders."""
    decoded, refusal = None, None
    try:
        with _opened(data) as raw:
            decoded = _decoded(raw)
    except UnreadableFileError as error:
        refusal = (error.code, error.message)
    make, model = ciff_names(data)
    container = Container(
        tags=tuple(read_exif(data)),
        make=make,
        model=model,
        wavelet_levels=wavelet_levels(data),
        fuji_lossy=fuji_is_lossy(data),
        fuji_rotated=fuji_is_rotated(data),
        end=declared_end(data),
    )
    return Description(decoded=decoded, refusal=refusal, container=container).as_plain(), None


def unpack(data: bytes, *, area: list[int], shape: list[int]) -> tuple[Mapping[str, Any], NDArray[np.uint16]]:
    """Return an area of a file's stored mosaic; in the process of the decoders.

    Parameters
    ----------
    data
        The file.
    area
        Top, left, bottom and right in raw coordinates [pixel].
    shape
        Rows and columns that the stored mosaic must have [pixel].

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where LibRaw does not decode it, or finds another size.

    """
    with _opened(data) as raw:
        stored = np.asarray(raw.raw_image)
        if stored.shape != tuple(shape):
            raise UnreadableFileError("file-damaged", "its pixels are not the size its header says; copy it again")
        top, left, bottom, right = area
        return {}, np.array(stored[top:bottom, left:right], dtype=np.uint16)


@contextmanager
def _opened(data: bytes) -> Generator["rawpy.RawPy"]:
    """Open and unpack a file; LibRaw's errors become ours."""
    import rawpy  # noqa: PLC0415 - loads when used

    raw = rawpy.RawPy()
    try:
        raw.open_buffer(io.BytesIO(data))
        yield raw
    except rawpy.LibRawFileUnsupportedError as error:
        raise UnreadableFileError("not-a-raw-file", "LibRaw knows no raw file like it") from error
    except rawpy.LibRawTooBigError as error:
        raise UnreadableFileError("file-damaged", "it claims more pixels than it can hold") from error
    except rawpy.LibRawIOError as error:
        raise UnreadableFileError("file-truncated", "it ends before its pixels do; copy it again") from error
    except rawpy.LibRawError as error:
        said = error.args[0].decode(errors="replace") if isinstance(error.args[0], bytes) else str(error)
        raise UnreadableFileError("file-damaged", f"LibRaw does not read it ({said}); copy the file again") from error
    finally:
        raw.close()


def _decoded(raw: "rawpy.RawPy") -> Decoded:
    import rawpy  # noqa: PLC0415 - loads when used

    sizes, stored = raw.sizes, np.asarray(raw.raw_image)
    top, left = sizes.top_margin, sizes.left_margin
    visible = Area(top, left, top + sizes.height, left + sizes.width)
    flat = raw.raw_type == rawpy.RawType.Flat and stored.ndim == 2
    white = int(raw.white_level)
    return Decoded(
        raw_width=stored.shape[1],
        raw_height=stored.shape[0],
        visible=visible,
        flip=sizes.flip,
        flat=flat,
        last_row_is_flat=bool(np.ptp(stored[-1]) == 0),
        pattern=_pattern(raw) if flat else (),
        colours=raw.color_desc.decode("ascii", "replace"),
        black=tuple(float(level) for level in raw.black_level_per_channel),
        linear=tuple(float(level) for level in raw.camera_white_level_per_channel or ()),
        white=white,
        iso=_finite(raw.other.iso_speed),
        exposure_s=_finite(raw.other.shutter_speed),
        longest_step=_longest_step(np.asarray(raw.tone_curve), white),
        balance=tuple(_finite(factor) for factor in raw.camera_whitebalance),
        matrix=tuple(float(one) for one in np.nan_to_num(np.asarray(raw.rgb_xyz_matrix)[:3].ravel())),
        margins=tuple(_margins(stored, visible)) if flat else (),
    )


def _pattern(raw: "rawpy.RawPy") -> tuple[int, ...]:
    """Return the number of each site's colour, counted from the visible top-left pixel; empty where LibRaw cannot say.

    LibRaw numbers its colours R, G1, B, G2 = 0, 1, 2, 3 with G1 and G2 wherever they fall, and lists levels by that
    number.
    """
    try:
        pattern = raw.raw_pattern
    except NotImplementedError:
        return ()
    return () if pattern is None else tuple(int(number) for number in pattern.ravel())


def _finite(value: float) -> float:
    return float(value) if math.isfinite(value) and value > 0 else 0.0


def _longest_step(curve: NDArray[np.uint16], white: int) -> int:
    """Return the longest step between codes that the file's tone curve leads to, up to its white level [DN]."""
    reached = np.unique(curve[: white + 1])
    reached = reached[reached <= white]
    return int(np.diff(reached.astype(np.int64)).max(initial=1))


def _margins(stored: NDArray[np.uint16], visible: Area) -> Iterator[Margin]:
    """Yield the margins beside the visible area."""
    height, width = stored.shape
    top, left, bottom, right = visible
    seen = stored[top:bottom:3, left:right:3]
    sides = (
        Area(0, left, top, right),
        Area(top, 0, bottom, left),
        Area(bottom, left, height, right),
        Area(top, right, bottom, width),
    )
    for side in sides:
        if seen.size and min(side.bottom - side.top, side.right - side.left) >= _LEAST_MARGIN:
            inner = stored[side.top + 1 : side.bottom - 1, side.left + 1 : side.right - 1]
            if inner.size:
                yield Margin(area=side, median=float(np.median(inner)), visible=float(np.median(seen)))
