"""Lossless JPEG (ITU-T T.81, process 14) as DNG files use it: headers parsed and checked here, samples in a kernel.

The JPEG's own width, height and components need not match the strip or tile; only the number of samples counts
(DNG 1.4, "Compression"). Phones and Adobe write two interleaved components, so that like colours predict each other.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError, UnsuitableFileError

if TYPE_CHECKING:
    from fullwell.kernels.lossless_jpeg import CodedScan

_SOI, _EOI, _SOS, _DHT, _DRI = 0xD8, 0xD9, 0xDA, 0xC4, 0xDD
_SOF_LOSSLESS: Final = 0xC3
_SOF_DCT: Final = (0xC0, 0xC1, 0xC2)
_SOF_OTHER: Final = (0xC5, 0xC6, 0xC7, 0xC9, 0xCA, 0xCB, 0xCD, 0xCE, 0xCF)
MOST_LINE_ROWS: Final = 2
"""Rows of a mosaic that a line holds: two of a Bayer mosaic, side by side, so that like colours are neighbours."""
_NO_PAYLOAD: Final = (0x01, *range(0xD0, 0xD9))


@dataclass(frozen=True, slots=True, kw_only=True)
class HuffmanTable:
    """A Huffman table: how many codes of each length 1 to 16 there are, and the category of each code."""

    counts: tuple[int, ...]
    categories: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LosslessScan:
    """Everything a decoder needs to know before the first coded bit.

    Parameters
    ----------
    width, height
        Samples per line and component, lines.
    precision
        Bits per sample.
    predictor
        1 to 7 (T.81, table H.1).
    shift
        Point transform: low bits that were dropped.
    tables
        Huffman table of each component, in scan order.
    start
        Position of the coded bits [byte].

    """

    width: int
    height: int
    precision: int
    predictor: int
    shift: int
    tables: tuple[HuffmanTable, ...]
    start: int

    @property
    def samples(self) -> int:
        """Samples of all components."""
        return self.width * self.height * len(self.tables)

    def is_like(self, other: "LosslessScan") -> bool:
        """Tell whether another scan has the same lines, coded the same way with as many different tables."""
        tables = [(len(scan.tables), len(set(scan.tables))) for scan in (self, other)]
        return tables[0] == tables[1] and replace(other, tables=self.tables, start=self.start) == self


def is_dct(stream: bytes) -> bool:
    """Return whether a JPEG stream (its first bytes suffice) is coded by cosine transform, that is, lossy."""
    try:
        return any(marker in _SOF_DCT for marker, _start, _stop in _markers(memoryview(stream)))
    except UnreadableFileError:
        return False


def parse_scan(stream: memoryview) -> LosslessScan:
    """Return the parameters of a lossless JPEG stream.

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where the markers make no sense.
    UnsuitableFileError
        ``lossy-compression`` for cosine-transform JPEG, ``unsupported-compression`` for restart intervals,
        subsampled components or other processes than 14.

    """
    tables: dict[int, HuffmanTable] = {}
    frame: bytes | None = None
    for marker, start, stop in _markers(stream):
        payload = bytes(stream[start:stop])
        if marker in _SOF_DCT:
            raise UnsuitableFileError(
                "lossy-compression", "the raw image is lossy JPEG; lossy coding changes its noise"
            )
        if marker == _SOF_LOSSLESS:
            frame = payload
        elif marker in _SOF_OTHER:
            raise UnsuitableFileError("unsupported-compression", f"JPEG process SOF{marker - 0xC0} is not read")
        elif marker == _DHT:
            tables |= _tables(payload)
        elif marker == _DRI and payload != b"\0\0":
            raise UnsuitableFileError("unsupported-compression", "lossless JPEG with restart intervals is not read")
        elif marker == _SOS and frame is not None:
            return _scan(frame, payload, tables=tables, start=stop)
    raise _damaged("it has no scan")


def _damaged(what: str) -> UnreadableFileError:
    return UnreadableFileError("file-damaged", f"a lossless JPEG segment is damaged: {what}; copy the file again")


def _markers(stream: memoryview) -> list[tuple[int, int, int]]:
    """Return each marker up to the first scan with the start and stop of its payload."""
    found: list[tuple[int, int, int]] = []
    position = 2
    if bytes(stream[:2]) != bytes((0xFF, _SOI)):
        raise _damaged("it does not begin as JPEG does")
    while position + 4 <= len(stream):
        if stream[position] != 0xFF:
            raise _damaged("a marker is missing")
        marker = stream[position + 1]
        if marker == 0xFF:
            position += 1
            continue
        if marker in _NO_PAYLOAD or marker == _EOI:
            raise _damaged("a marker stands where none may")
        stop = position + 2 + struct.unpack_from(">H", stream, position + 2)[0]
        if stop < position + 4 or stop > len(stream):
            raise _damaged("a marker is longer than the segment")
        found.append((marker, position + 4, stop))
        if marker == _SOS:
            break
        position = stop
    return found


def _tables(payload: bytes) -> dict[int, HuffmanTable]:
    tables: dict[int, HuffmanTable] = {}
    position = 0
    while position + 17 <= len(payload):
        counts = tuple(payload[position + 1 : position + 17])
        stop = position + 17 + sum(counts)
        categories = tuple(payload[position + 17 : stop])
        codes = sum(count << (16 - length) for length, count in enumerate(counts, start=1))
        if len(categories) != sum(counts) or codes > 1 << 16 or any(category > 16 for category in categories):
            raise _damaged("its Huffman table is impossible")
        tables[payload[position] & 0x0F] = HuffmanTable(counts=counts, categories=categories)
        position = stop
    return tables


def _scan(frame: bytes, payload: bytes, *, tables: dict[int, HuffmanTable], start: int) -> LosslessScan:
    if len(frame) < 6 or len(frame) < 6 + 3 * frame[5] or not payload or len(payload) < 4 + 2 * payload[0]:
        raise _damaged("its frame header is cut")
    precision, height, width, components = struct.unpack_from(">BHHB", frame)
    if not (2 <= precision <= 16 and height and width and 1 <= components <= 4):
        raise _damaged("its frame header is impossible")
    if any(frame[7 + 3 * index] != 0x11 for index in range(components)) or payload[0] != components:
        raise UnsuitableFileError("unsupported-compression", "lossless JPEG with subsampled components is not read")
    predictor, shift = payload[1 + 2 * components], payload[3 + 2 * components] & 0x0F
    chosen = [payload[2 + 2 * index] >> 4 for index in range(components)]
    if not 1 <= predictor <= 7 or shift >= precision or any(index not in tables for index in chosen):
        raise _damaged("its scan header is impossible")
    return LosslessScan(
        width=width,
        height=height,
        precision=precision,
        predictor=predictor,
        shift=shift,
        tables=tuple(tables[index] for index in chosen),
        start=start,
    )


def decode_lossless(stream: memoryview, *, samples: int, out: NDArray[np.uint16] | None = None) -> NDArray[np.uint16]:
    """Return the samples of a lossless JPEG segment in coded order, components interleaved.

    Parameters
    ----------
    stream
        The segment.
    samples
        Samples that are needed; the stream may hold more.
    out
        C-contiguous memory for so many samples, taken where the stream holds no more.

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where the stream ends early or makes no sense.
    UnsuitableFileError
        As `parse_scan`.

    """
    scan = _plausible(stream, samples)
    decoded = np.empty(scan.samples, np.uint16) if out is None or scan.samples != samples else out.reshape(-1)
    _decode_whole([(scan, stream)], [decoded])
    return decoded


def decode_lossless_pair(streams: Sequence[memoryview], *, samples: Sequence[int]) -> list[NDArray[np.uint16]]:
    """Return the samples of two segments, which is faster than one after the other where they are coded alike.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `decode_lossless`.

    """
    segments = [(_plausible(stream, needed), stream) for stream, needed in zip(streams, samples, strict=True)]
    decoded = [np.empty(scan.samples, np.uint16) for scan, _stream in segments]
    if segments[0][0].is_like(segments[1][0]):
        _decode_whole(segments, decoded)
    else:
        for segment, memory in zip(segments, decoded, strict=True):
            _decode_whole([segment], [memory])
    return decoded


def _decode_whole(segments: Sequence[tuple[LosslessScan, memoryview]], decoded: Sequence[NDArray[np.uint16]]) -> None:
    """Decode one segment or two of one shape into memory for their samples."""
    scan, _stream = segments[0]
    lines = [memory.reshape(scan.height, -1) for memory in decoded]
    _decode_lines(scan, [_coded(each, stream) for each, stream in segments], lines)
    if scan.shift:
        for samples in decoded:
            np.left_shift(samples, scan.shift, out=samples)


class LosslessLines:
    """A lossless JPEG segment that is decoded some lines at a time, from the first to the last.

    Parameters
    ----------
    stream
        The segment; it must stay as it is.
    shape
        Rows and columns of the mosaic that it is.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `decode_lossless`.

    """

    def __init__(self, stream: memoryview, shape: tuple[int, int]) -> None:
        self._scan = _plausible(stream, shape[0] * shape[1])
        self._coded = _coded(self._scan, stream)
        line = self._scan.width * len(self._scan.tables)
        rows = line // shape[1]
        fits = (rows * self._scan.height, line) == (shape[0], rows * shape[1]) and rows <= MOST_LINE_ROWS
        self.rows = rows if fits and not self._scan.shift else 0

    def read(self, out: NDArray[np.uint16], *, above: bool) -> None:
        """Decode the next lines; ``rows`` tells how many rows of the mosaic each is, 0 where they are no whole rows.

        Parameters
        ----------
        out
            Where they go, shape (lines, samples of a line).
        above
            Whether the first of them is the last one before, which is known.

        Raises
        ------
        UnreadableFileError
            ``file-damaged``.

        """
        _decode_lines(self._scan, [self._coded], [out], above=above)


def _coded(scan: LosslessScan, stream: memoryview) -> "CodedScan":
    from fullwell.kernels.lossless_jpeg import CodedScan  # noqa: PLC0415 - loads the JIT when used
    from fullwell.kernels.lossless_jpeg_tables import decoding_tables  # noqa: PLC0415 - the same

    data = np.frombuffer(stream, dtype=np.uint8)[scan.start :]
    tables = decoding_tables(tuple((table.counts, table.categories) for table in scan.tables))
    return CodedScan(data=data, tables=tables)


def _decode_lines(
    scan: LosslessScan, coded: Sequence["CodedScan"], lines: Sequence[NDArray[np.uint16]], *, above: bool = False
) -> None:
    """Decode the next lines of one scan, or of two alike."""
    from fullwell.kernels import lossless_jpeg as kernel  # noqa: PLC0415 - loads the JIT when used

    outcome = kernel.decode_lines(
        coded,
        lines,
        components=len(scan.tables),
        start_value=1 << (scan.precision - scan.shift - 1),
        predictor=scan.predictor,
        above=above,
    )
    if outcome == kernel.ENDED_EARLY:
        raise _damaged("it ends early")
    if outcome != kernel.COMPLETE:
        raise _damaged("it holds an impossible code")


def _plausible(stream: memoryview, samples: int) -> LosslessScan:
    scan = parse_scan(stream)
    if scan.samples < samples:
        raise _damaged(f"it holds {scan.samples} pixels of {samples}")
    if scan.samples > 8 * len(stream):
        raise _damaged("it is too short for its pixels")
    return scan
