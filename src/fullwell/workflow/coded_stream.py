"""Files of lossless JPEG pass through a little memory too: they are read as they are, and decoded strip by strip."""

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Band
from fullwell.raw.lossless_jpeg import LosslessLines
from fullwell.raw.open import decode, mosaic_coded_at
from fullwell.raw.remote import RemotePath
from fullwell.workflow.stream import LostFrameError


def decodes(frame: Frame) -> bool:
    """Tell whether a file on a disk can be decoded some lines at a time."""
    return mosaic_coded_at(frame.header) is not None and not isinstance(frame.header.path, RemotePath)


class DecodedStream:
    """A mosaic in memory whose rows are copied to where strips are looked for.

    Parameters
    ----------
    frame
        Whose.
    mosaic
        Shape (height, width) [DN].
    room
        Memory for a strip of it and the line above.

    """

    def __init__(self, frame: Frame, mosaic: NDArray[np.uint16], room: NDArray[np.uint16]) -> None:
        self.frame = frame
        self._mosaic = mosaic
        self._room = _lines_of(room, mosaic.shape[1])

    def read(self, strip: Band) -> None:
        """Copy a strip into the room, below its first line."""
        self._room[1 : strip.bottom - strip.top + 1] = self._mosaic[strip.top : strip.bottom]

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
        Memory for a strip of it and the line above.

    """

    def __init__(self, frame: Frame, lines: LosslessLines, room: NDArray[np.uint16]) -> None:
        self.frame = frame
        self._room = _lines_of(room, frame.header.width)
        self._rows = 0
        self._lines = lines

    def read(self, strip: Band) -> None:
        """Decode a strip into the room, below its first line; strips follow each other from the top.

        Raises
        ------
        LostFrameError
            The file is damaged.

        """
        self._room[0] = self._room[self._rows]
        self._rows = strip.bottom - strip.top
        above = strip.top > 0
        try:
            self._lines.read(self._room[0 if above else 1 : self._rows + 1], above=above)
        except RawFileError as error:
            raise LostFrameError(self.frame, error) from error

    def close(self) -> None:
        """Have nothing to let go."""


def coded_stream(frame: Frame, data: memoryview, room: NDArray[np.uint16]) -> CodedStream | DecodedStream:
    """Return a file that is decoded strip by strip, or has been where its lines are not those of the mosaic.

    Parameters
    ----------
    frame
        Which; one that ``decodes``.
    data
        Its bytes, which must stay as they are.
    room
        Memory for a strip of it and the line above.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        It cannot be decoded.

    """
    header, where = frame.header, mosaic_coded_at(frame.header)
    if where is None or where.stop > len(data):
        raise UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
    lines = LosslessLines(data[where], (header.height, header.width))
    return CodedStream(frame, lines, room) if lines.fits else DecodedStream(frame, decode(header, data), room)


def _lines_of(room: NDArray[np.uint16], width: int) -> NDArray[np.uint16]:
    return room[: room.size // width * width].reshape(-1, width)
