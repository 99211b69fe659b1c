"""Files that must be decoded pass through a little memory too: read as they are, decoded some rows at a time."""

from contextlib import suppress
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Band
from fullwell.raw.lossless_jpeg import MOST_LINE_ROWS, LosslessLines
from fullwell.raw.open import decode, decode_rows, mosaic_coded_at, segment_rows_of
from fullwell.raw.remote import RemotePath
from fullwell.statistics.moments import Layout
from fullwell.workflow.stream import HashedFile, LostFrameError, Told, streams

_SPARE: Final = 8
"""Coded bytes that are a part of this more than others fit into their memory."""


def decodes(frame: Frame) -> bool:
    """Tell whether a file on a disk can be decoded some rows at a time."""
    header = frame.header
    if isinstance(header.path, RemotePath) or streams(frame):
        return False
    return mosaic_coded_at(header) is not None or segment_rows_of(header) is not None


def room_bytes(frame: Frame, layout: Layout) -> int:
    """Return the memory that a file needs which ``decodes``: for a strip, and for rows that are decoded together."""
    segments = segment_rows_of(frame.header)
    return layout.strip_bytes + 2 * layout.width * (MOST_LINE_ROWS if segments is None else segments.rows)


class CodedMemory:
    """Memory for coded bytes that grows as it must, and is used again."""

    def __init__(self) -> None:
        self._block = np.empty(0, np.uint8)

    def take(self, size: int) -> memoryview:
        """Return memory of a size; what was in it before may be gone."""
        if self._block.size < size:
            self._block = np.empty(size + size // _SPARE, np.uint8)
        return self._block.data[:size]


class DecodedStream:
    """A mosaic in memory whose rows are copied to where strips are looked for.

    Parameters
    ----------
    frame
        Whose.
    mosaic
        Shape (height, width) [DN].
    room
        Memory for a strip of it.

    """

    def __init__(self, frame: Frame, mosaic: NDArray[np.uint16], room: NDArray[np.uint16]) -> None:
        self.frame = frame
        self._mosaic = mosaic
        self._room = _lines_of(room, mosaic.shape[1])

    def read(self, strip: Band) -> int:
        """Copy a strip into the room, and return the row that the room begins with."""
        self._room[: strip.bottom - strip.top] = self._mosaic[strip.top : strip.bottom]
        return strip.top

    def close(self) -> None:
        """Have nothing to let go."""


class CodedStream:
    """A file in memory whose lines are decoded once, from the first to the last.

    Parameters
    ----------
    frame
        Which.
    lines
        Its decoder.
    room
        Memory for a strip of it and for a line above.

    """

    def __init__(self, frame: Frame, lines: LosslessLines, room: NDArray[np.uint16]) -> None:
        self.frame = frame
        self._step = lines.rows
        self._room = _lines_of(room, lines.rows * frame.header.width)
        self._held = 0
        self._lines = lines

    def read(self, strip: Band) -> int:
        """Decode a strip into the room, below the line above; return the row that the room begins with.

        Strips follow each other from the top.

        Raises
        ------
        LostFrameError
            The file is damaged.

        """
        self._room[0] = self._room[self._held]
        self._held = (strip.bottom - strip.top) // self._step
        above = strip.top > 0
        try:
            self._lines.read(self._room[0 if above else 1 : self._held + 1], above=above)
        except RawFileError as error:
            raise LostFrameError(self.frame, error) from error
        return strip.top - self._step

    def close(self) -> None:
        """Have nothing to let go."""


class SegmentStream:
    """A file whose segments are read and decoded once, a row of them after the other.

    Parameters
    ----------
    frame
        Which; one that has `segment_rows_of`.
    memory
        For coded bytes.
    room
        Memory of ``room_bytes``.
    told
        Told of its hash once it has been read.

    Raises
    ------
    OSError
        The file cannot be opened.

    """

    def __init__(self, frame: Frame, memory: CodedMemory, room: NDArray[np.uint16], told: Told) -> None:
        segments = segment_rows_of(frame.header)
        if segments is None:
            raise ValueError(f"{frame.name} has no rows of segments")
        self.frame = frame
        self._segments = segments
        self._memory = memory
        self._room = _lines_of(room, frame.header.width)
        self._told = told
        self._next = frame.header.active_area.top // segments.rows
        self._top = self._bottom = 0
        self._file = HashedFile(frame.header)

    @property
    def complete(self) -> bool:
        """Tell whether the file has all its pixels."""
        return self._file.holds(self._segments.at[-1].stop)

    def read(self, strip: Band) -> int:
        """Read and decode what is missing of a strip; return the row that the room begins with.

        Strips follow each other from the top.

        Raises
        ------
        LostFrameError
            The file cannot be read, or is damaged.

        """
        if strip.bottom > self._bottom:
            kept = self._bottom - strip.top
            self._room[:kept] = self._room[strip.top - self._top : self._bottom - self._top]
            self._top = strip.top
            try:
                self._decode(strip.bottom, self._room[kept:])
                if self._bottom == self.frame.header.height:
                    self._finish()
            except (RawFileError, OSError) as error:
                with suppress(RawFileError, OSError):
                    self._finish()
                raise LostFrameError(self.frame, error) from error
        return self._top

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

    def _decode(self, bottom: int, room: NDArray[np.uint16]) -> None:
        """Decode further rows of segments, down to some row of the mosaic at least."""
        header, (rows, at) = self.frame.header, self._segments
        above = header.active_area.top
        until = -(-(above + bottom) // rows)
        bottom = min(until * rows - above, header.height)
        coded = slice(at[self._next].start, at[until - 1].stop)
        data = self._memory.take(coded.stop - coded.start)
        self._file.pass_over(coded.start)
        self._file.read(data)
        out = room[: bottom - self._bottom]
        decode_rows(header, data, (self._bottom, bottom), first_byte=coded.start, out=out)
        self._next, self._bottom = until, bottom

    def _finish(self) -> None:
        self._file.pass_over()
        self._told(self.frame, self._file.hash)


def coded_stream(
    frame: Frame, data: memoryview, room: NDArray[np.uint16], layout: Layout
) -> CodedStream | DecodedStream:
    """Return a file that is decoded some lines at a time, or has been where strips do not begin with its lines.

    Parameters
    ----------
    frame
        Which; one that is lossless JPEG as a whole.
    data
        Its bytes, which must stay as they are.
    room
        Memory of ``room_bytes``.
    layout
        Whose strips are read.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        It cannot be decoded.

    """
    header, where = frame.header, mosaic_coded_at(frame.header)
    if where is None or where.stop > len(data):
        raise UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
    lines = LosslessLines(data[where], (header.height, header.width))
    if lines.rows and all(strip.top % lines.rows == 0 for strip in layout.strips()):
        return CodedStream(frame, lines, room)
    return DecodedStream(frame, decode(header, data), room)


def _lines_of(room: NDArray[np.uint16], width: int) -> NDArray[np.uint16]:
    return room[: room.size // width * width].reshape(-1, width)
