"""Uncompressed files pass through a little memory, strip by strip, and are hashed on their way."""

import os
from typing import Final

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Band
from fullwell.raw.open import mosaic_at
from fullwell.raw.remote import RemotePath

_PIECE: Final = 1 << 16
_AHEAD: Final = 1 << 21
"""Asked of the system in one go, so that a disk does not go to and fro between files [byte]."""


class LostFrameError(Exception):
    """A frame failed after a part of it had been added, so that the sums of its series must be made again.

    Parameters
    ----------
    frame
        Which.
    cause
        What happened.

    """

    def __init__(self, frame: Frame, cause: RawFileError | OSError) -> None:
        super().__init__(frame.name)
        self.frame = frame
        self.cause = cause


def streams(frame: Frame) -> bool:
    """Tell whether a file on a disk holds a frame's mosaic as it is, so that it need not be in memory as a whole."""
    return mosaic_at(frame.header) is not None and not isinstance(frame.header.path, RemotePath)


class Stream:
    """A file that is read once, from the first byte of a frame to the last.

    Parameters
    ----------
    frame
        Which; one that ``streams``.
    room
        Memory for a strip of it.

    Raises
    ------
    OSError
        The file cannot be opened.

    """

    def __init__(self, frame: Frame, room: NDArray[np.uint8]) -> None:
        header = frame.header
        self.frame = frame
        self._room = room.data
        self._file = header.path.open("rb", buffering=0)
        self._size = os.fstat(self._file.fileno()).st_size
        self._at, self._stop = header.extent or (0, self._size)
        self._top = self._at + (mosaic_at(header) or 0)
        self._asked = self._at
        self._row_bytes, self._height = 2 * header.width, header.height
        self._digest = xxh3_128()
        self._file.seek(self._at)

    @property
    def complete(self) -> bool:
        """Tell whether the file has all its pixels."""
        return self._top + self._height * self._row_bytes <= self._stop <= self._size

    @property
    def hash(self) -> str:
        """Return the hash of what was read."""
        return self._digest.hexdigest()

    def read(self, strip: Band) -> int:
        """Read a strip into the room, and return the row that the room begins with; strips follow from the top.

        Raises
        ------
        LostFrameError
            The file cannot be read, or has become shorter.

        """
        try:
            if strip.top == 0:
                self._pass_over(self._top)
            size = (strip.bottom - strip.top) * self._row_bytes
            self._at += size
            if self._at > self._asked - _AHEAD:
                self._ask()
            piece = self._room[:size]
            count = self._file.readinto(piece)
            if count < size:
                self._fill(piece, count)
            self._digest.update(piece)
            if strip.bottom == self._height:
                self._pass_over(self._stop)
        except (RawFileError, OSError) as error:
            raise LostFrameError(self.frame, error) from error
        return strip.top

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

    def _fill(self, piece: memoryview, filled: int) -> None:
        """Read on where the system gave less than it was asked for."""
        while filled < len(piece):
            count = self._file.readinto(piece[filled:])
            if not count:
                raise _ended()
            filled += count

    def _pass_over(self, until: int) -> None:
        while self._at < until:
            piece = self._file.read(min(_PIECE, until - self._at))
            if not piece:
                raise _ended()
            self._digest.update(piece)
            self._at += len(piece)

    def _ask(self) -> None:
        """Let the system read on, where it takes such advice, before what it was asked for is used up."""
        if hasattr(os, "posix_fadvise"):
            os.posix_fadvise(self._file.fileno(), self._asked, 2 * _AHEAD, os.POSIX_FADV_WILLNEED)
        self._asked += 2 * _AHEAD


def _ended() -> UnreadableFileError:
    return UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
