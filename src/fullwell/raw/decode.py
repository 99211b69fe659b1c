"""The stored segments of a TIFF or DNG image become the visible mosaic, with no more copies than it takes.

Uncompressed little-endian 16-bit strips that follow each other, without margins, are not copied at all.
"""

import sys
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.raw.image import Area
from fullwell.raw.isolation import ask
from fullwell.raw.segments import Layout
from fullwell.raw.tags import Compression

_NATIVE: Final = "<" if sys.byteorder == "little" else ">"


def decode_segments(
    layout: Layout, data: memoryview, area: Area, *, out: NDArray[np.uint16] | None = None
) -> NDArray[np.uint16]:
    """Return the visible mosaic of a stored image.

    Parameters
    ----------
    layout
        Where the segments lie.
    data
        The whole file.
    area
        Visible mosaic in raw coordinates.
    out
        Memory for the mosaic where it is not a view of ``data``, of its shape; None takes new memory.

    Returns
    -------
    ndarray
        Shape (area.bottom - area.top, area.right - area.left), C-contiguous; a read-only view of ``data`` where that
        is possible. A LinearizationTable is applied [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.
    UnsuitableFileError
        Where a segment turns out to be coded in a way that is not read.

    """
    view = _in_place(layout, data, area)
    if view is not None:
        return view
    if layout.row_interleave > 1 or layout.column_interleave > 1:
        whole = _assemble(layout, data, Area(0, 0, layout.height, layout.width))
        ordered = _deinterleaved(whole, rows=layout.row_interleave, columns=layout.column_interleave)
        return np.ascontiguousarray(ordered[area.top : area.bottom, area.left : area.right])
    return _assemble(layout, data, area, out=out)


def rows_at(layout: Layout, area: Area) -> int | None:
    """Return where the visible mosaic begins, if it lies in the file row after row as it is; else None [byte]."""
    whole = area == Area(0, 0, layout.height, layout.width)
    plain = layout.compression == Compression.NONE and layout.bits == 16 and not layout.table
    interleaved = layout.row_interleave > 1 or layout.column_interleave > 1
    if not (
        whole and plain and not interleaved and layout.byte_order == _NATIVE and layout.segment_width == layout.width
    ):
        return None
    strip_bytes = layout.row_bytes * layout.segment_height
    start = layout.offsets[0]
    return start if all(offset == start + index * strip_bytes for index, offset in enumerate(layout.offsets)) else None


def coded_at(layout: Layout, area: Area) -> slice | None:
    """Return where the one segment of lossless JPEG lies that is the visible mosaic; None where there is no such."""
    whole = area == Area(0, 0, layout.height, layout.width)
    single = len(layout.offsets) == 1 and (layout.segment_height, layout.segment_width) == (layout.height, layout.width)
    interleaved = layout.row_interleave > 1 or layout.column_interleave > 1
    if not (whole and single and layout.compression == Compression.JPEG) or interleaved or layout.table:
        return None
    return slice(layout.offsets[0], layout.offsets[0] + layout.counts[0])


class SegmentRows(NamedTuple):
    """Segments of so many ``rows`` each, side by side, and ``at`` which bytes of the file each row of them lies."""

    rows: int
    at: tuple[slice, ...]


def segment_rows(layout: Layout) -> SegmentRows | None:
    """Return where the rows of segments lie; None where there is one, or they do not follow each other as rows do."""
    if layout.row_interleave > 1 or layout.column_interleave > 1:
        return None
    stops = [offset + count for offset, count in zip(layout.offsets, layout.stored_bytes, strict=True)]
    rows = [slice(k, k + layout.across) for k in range(0, len(stops), layout.across)]
    at = tuple(slice(min(layout.offsets[row]), max(stops[row])) for row in rows)
    ordered = all(one.stop <= other.start for one, other in pairwise(at))
    return SegmentRows(layout.segment_height, at) if ordered and len(at) > 1 else None


def _in_place(layout: Layout, data: memoryview, area: Area) -> NDArray[np.uint16] | None:
    """Return the mosaic as a view of the file, or None where it must be copied."""
    start = rows_at(layout, area)
    if start is None:
        return None
    if len(data) < start + layout.row_bytes * layout.height:
        raise _truncated()
    pixels = np.frombuffer(data, dtype=np.uint16, count=layout.width * layout.height, offset=start)
    return pixels.reshape(layout.height, layout.width) if pixels.flags.aligned else None


def _assemble(
    layout: Layout, data: memoryview, area: Area, *, out: NDArray[np.uint16] | None = None
) -> NDArray[np.uint16]:
    shape = (area.bottom - area.top, area.right - area.left)
    mosaic = np.empty(shape, dtype=np.uint16) if out is None or out.shape != shape else out
    parts = [_part(layout, segment, mosaic, area) for segment in range(len(layout.offsets))]
    visible = [part for part in parts if part.target.size]
    if layout.compression == Compression.JPEG and len(visible) > 1:
        _fill_from_jpeg(visible, layout, data)
    else:
        for part in visible:
            _fill(part, layout, data)
    table = _full_table(layout)
    if table is not None:
        np.take(table, mosaic, out=mosaic, mode="clip")
    return mosaic


@dataclass(frozen=True, slots=True, kw_only=True)
class _Part:
    """What is visible of a segment: from which of its rows and columns on, and where in the mosaic it goes."""

    segment: int
    row: int
    column: int
    target: NDArray[np.uint16]

    def take(self, block: NDArray[np.integer]) -> None:
        """Copy it from the whole segment."""
        rows, columns = self.target.shape
        self.target[...] = block[self.row : self.row + rows, self.column : self.column + columns]


def _part(layout: Layout, segment: int, mosaic: NDArray[np.uint16], area: Area) -> _Part:
    top = segment // layout.across * layout.segment_height
    left = segment % layout.across * layout.segment_width
    first_row, first_column = max(top, area.top), max(left, area.left)
    last_row = min(top + layout.rows(segment), layout.height, area.bottom)
    last_column = min(left + layout.segment_width, layout.width, area.right)
    rows = slice(first_row - area.top, max(last_row, first_row) - area.top)
    columns = slice(first_column - area.left, max(last_column, first_column) - area.left)
    return _Part(segment=segment, row=first_row - top, column=first_column - left, target=mosaic[rows, columns])


def _fill(part: _Part, layout: Layout, data: memoryview) -> None:
    """Write a part of a segment into the mosaic."""
    stored = _stored_bytes(layout, data, part.segment)
    if layout.compression == Compression.NONE and layout.bits not in {8, 16}:
        from fullwell.kernels.unpacking import unpack_rows  # noqa: PLC0415 - loads the JIT when used

        packed = np.frombuffer(stored, dtype=np.uint8)[part.row * layout.row_bytes :]
        unpack_rows(packed, part.target, bits=layout.bits, row_bytes=layout.row_bytes, first_column=part.column)
        return
    whole = part.target.flags.c_contiguous and part.target.shape == (layout.rows(part.segment), layout.segment_width)
    block = _block(layout, stored, part.segment, out=part.target if whole else None)
    if not np.may_share_memory(block, part.target):
        part.take(block)


def _fill_from_jpeg(parts: list[_Part], layout: Layout, data: memoryview) -> None:
    """Write parts of lossless JPEG segments into the mosaic, two segments at a time."""
    from fullwell.raw.lossless_jpeg import decode_lossless_pair  # noqa: PLC0415 - loads the JIT when used

    for pair in zip(parts[::2], parts[1::2], strict=False):
        shapes = [(layout.rows(part.segment), layout.segment_width) for part in pair]
        stored = [_stored_bytes(layout, data, part.segment) for part in pair]
        needed = [rows * columns for rows, columns in shapes]
        for part, block, shape in zip(pair, decode_lossless_pair(stored, samples=needed), shapes, strict=True):
            part.take(_exactly(block, shape))
    if len(parts) % 2:
        _fill(parts[-1], layout, data)


def _stored_bytes(layout: Layout, data: memoryview, segment: int) -> memoryview:
    offset = layout.offsets[segment]
    uncompressed = layout.compression == Compression.NONE
    count = layout.row_bytes * layout.rows(segment) if uncompressed else layout.counts[segment]
    if offset + count > len(data):
        raise _truncated()
    return data[offset : offset + count].toreadonly()


def _block(layout: Layout, stored: memoryview, segment: int, *, out: NDArray[np.uint16] | None) -> NDArray[np.integer]:
    """Return a whole segment, shape (its rows, segment_width), any integer type; perhaps in ``out``, of that shape."""
    shape = (layout.rows(segment), layout.segment_width)
    if layout.compression == Compression.JPEG:
        from fullwell.raw.lossless_jpeg import decode_lossless  # noqa: PLC0415 - loads the JIT when used

        return _exactly(decode_lossless(stored, samples=shape[0] * shape[1], out=out), shape)
    if layout.compression == Compression.NONE:
        return _words(layout, stored, shape)
    try:
        return _decompressed(layout, stored, shape)
    except RawFileError:
        raise
    except Exception as error:  # each codec fails in its own way, and all mean the same
        raise UnreadableFileError(
            "file-damaged", f"segment {segment} cannot be decompressed ({error}); copy the file again"
        ) from error


def _words(layout: Layout, stored: memoryview | bytes | bytearray, shape: tuple[int, int]) -> NDArray[np.integer]:
    dtype = np.dtype("u1" if layout.bits == 8 else f"{layout.byte_order}u2")
    return _exactly(np.frombuffer(stored, dtype=dtype), shape)


def _decompressed(layout: Layout, stored: memoryview, shape: tuple[int, int]) -> NDArray[np.integer]:
    if layout.compression == Compression.JPEG_XL:
        pixels = np.empty(shape, np.uint16)
        ask("jpeg-xl", stored, out=pixels, shape=list(shape))
        return pixels
    import imagecodecs  # noqa: PLC0415 - loads when used

    if layout.bits not in {8, 16}:
        raise UnsuitableFileError("unsupported-compression", "compressed packed samples are not read")
    size, coded = layout.row_bytes * shape[0], bytes(stored)
    if layout.compression == Compression.LZW:
        plain = imagecodecs.lzw_decode(coded, out=size)
    elif layout.compression == Compression.PACKBITS:
        plain = imagecodecs.packbits_decode(coded, out=size)
    else:
        plain = imagecodecs.zlib_decode(coded, out=size)
    words = _words(layout, plain, shape)
    if layout.predictor == 1:
        return words
    return np.cumsum(words, axis=1, dtype=np.uint8 if layout.bits == 8 else np.uint16)


def _exactly(samples: NDArray[np.integer], shape: tuple[int, int]) -> NDArray[np.integer]:
    """Return the first samples of a segment in its shape."""
    needed = shape[0] * shape[1]
    if samples.size < needed:
        raise UnreadableFileError("file-damaged", f"a segment holds {samples.size} pixels of {needed}; copy it again")
    return samples.reshape(-1)[:needed].reshape(shape)


def _full_table(layout: Layout) -> NDArray[np.uint16] | None:
    """Return the LinearizationTable; codes beyond its end take its last value (DNG 1.4, chapter 5)."""
    return np.asarray(layout.table, dtype=np.uint16) if layout.table else None


def _deinterleaved(stored: NDArray[np.uint16], *, rows: int, columns: int) -> NDArray[np.uint16]:
    """Undo DNG row and column interleaving: the stored fields 0, 1, ... hold every ``rows``-th row from 0, 1, ..."""
    row_order = np.concatenate([np.arange(field, stored.shape[0], rows) for field in range(rows)])
    column_order = np.concatenate([np.arange(field, stored.shape[1], columns) for field in range(columns)])
    ordered = np.empty_like(stored)
    ordered[np.ix_(row_order, column_order)] = stored
    return ordered


def _truncated() -> UnreadableFileError:
    return UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
