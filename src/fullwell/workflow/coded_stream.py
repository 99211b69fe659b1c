"""Files that must be decoded pass through a little memory too: read as they are, decoded some rows at a time."""

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Band
from fullwell.raw.lossless_jpeg import MOST_LINE_ROWS, LosslessLines
from fullwell.raw.open import decode, decode_rows, mosaic_coded_at, rows_coded_together
from fullwell.raw.remote import RemotePath
from fullwell.statistics.moments import Layout
from fullwell.workflow.stream import LostFrameError, streams


def decodes(frame: Frame) -> bool:
    """Tell whether a file on a disk can be decoded some lines at a time."""
    remote = isinstance(frame.header.path, RemotePath)
    return not remote and not streams(frame) and frame_rows(frame) < frame.header.height


def room_bytes(frame: Frame, layout: Layout) -> int:
    """Return the memory that a file needs which ``decodes``: for a strip, and for rows that are decoded together."""
    return layout.strip_bytes + 2 * layout.width * frame_rows(frame)


def frame_rows(frame: Frame) -> int:
    """Return how many rows of a frame are decoded together."""
    if mosaic_coded_at(frame.header) is not None:
        return MOST_LINE_ROWS
    return rows_coded_together(frame.header) or frame.header.height


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
    """A file in memory whose segments are decoded once, a row of them after the other.

    Parameters
    ----------
    frame
        Which.
    data
        Its bytes.
    room
        Memory for a strip of it and for a row of segments.

    """

    def __init__(self, frame: Frame, data: memoryview, room: NDArray[np.uint16]) -> None:
        self.frame = frame
        self._data = data
        self._room = _lines_of(room, frame.header.width)
        self._together = frame_rows(frame)
        self._top = self._bottom = 0

    def read(self, strip: Band) -> int:
        """Decode what is missing of a strip; return the row that the room begins with.

        Strips follow each other from the top.

        Raises
        ------
        LostFrameError
            The file is damaged.

        """
        if strip.bottom > self._bottom:
            header = self.frame.header
            above, together = header.active_area.top, self._together
            bottom = min(-(-(above + strip.bottom) // together) * together - above, header.height)
            kept = self._bottom - strip.top
            self._room[:kept] = self._room[strip.top - self._top : self._bottom - self._top]
            rows = self._room[kept : kept + bottom - self._bottom]
            try:
                decode_rows(header, self._data, (self._bottom, bottom), out=rows)
            except RawFileError as error:
                raise LostFrameError(self.frame, error) from error
            self._top, self._bottom = strip.top, bottom
        return self._top

    def close(self) -> None:
        """Have nothing to let go."""


AnyCodedStream = CodedStream | DecodedStream | SegmentStream


def coded_stream(frame: Frame, data: memoryview, room: NDArray[np.uint16]) -> AnyCodedStream:
    """Return a file that is decoded some rows at a time, or has been where its lines are not those of the mosaic.

    Parameters
    ----------
    frame
        Which; one that ``decodes``.
    data
        Its bytes, which must stay as they are.
    room
        Memory of ``room_bytes``.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        It cannot be decoded.

    """
    header, where = frame.header, mosaic_coded_at(frame.header)
    if where is None:
        return SegmentStream(frame, data, room)
    if where.stop > len(data):
        raise UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
    lines = LosslessLines(data[where], (header.height, header.width))
    return CodedStream(frame, lines, room) if lines.rows else DecodedStream(frame, decode(header, data), room)


def _lines_of(room: NDArray[np.uint16], width: int) -> NDArray[np.uint16]:
    return room[: room.size // width * width].reshape(-1, width)
