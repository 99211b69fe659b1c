"""Uncompressed files pass through a little memory, strip by strip, and are hashed on their way."""

import os
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import RawFileError, UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Band
from fullwell.raw.image import RawHeader
from fullwell.raw.open import mosaic_at
from fullwell.raw.remote import RemotePath

Told = Callable[[Frame, str], None]

_PIECE: Final = 1 << 16
"""Of what is hashed but not used, read in one go [byte]."""
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


class HashedFile:
    """A file that is read once, from the first byte of a frame to the last, and hashed on its way.

    Parameters
    ----------
    header
        Of the frame.

    Raises
    ------
    OSError
        The file cannot be opened.

    """

    def __init__(self, header: RawHeader) -> None:
        self._file = header.path.open("rb", buffering=0)
        self._size = os.fstat(self._file.fileno()).st_size
        self._start, self._stop = header.extent or (0, self._size)
        self._at = self._asked = self._start
        self._digest = xxh3_128()
        self._file.seek(self._start)

    @property
    def hash(self) -> str:
        """Return the hash of what was read."""
        return self._digest.hexdigest()

    def holds(self, until: int) -> bool:
        """Tell whether the frame goes on up to some byte of it."""
        return self._start + until <= self._stop <= self._size

    def read(self, piece: memoryview) -> None:
        """Read the next bytes.

        Raises
        ------
        OSError, UnreadableFileError
            The file cannot be read, or has become shorter.

        """
        size = len(piece)
        self._at += size
        if self._at > self._asked - _AHEAD:
            self._ask()
        filled = self._file.readinto(piece)
        while filled < size:
            count = self._file.readinto(piece[filled:])
            if not count:
                raise _ended()
            filled += count
        self._digest.update(piece)

    def pass_over(self, until: int | None = None) -> None:
        """Hash what comes before some byte of the frame, or all of it; errors as `read`."""
        stop = self._stop if until is None else self._start + until
        while self._at < stop:
            piece = self._file.read(min(_PIECE, stop - self._at))
            if not piece:
                raise _ended()
            self._digest.update(piece)
            self._at += len(piece)

    def close(self) -> None:
        """Let the file go."""
        self._file.close()

    def _ask(self) -> None:
        """Let the system read on, where it takes such advice, before what it was asked for is used up."""
        if hasattr(os, "posix_fadvise") and not self._is_at_hand(self._asked):
            os.posix_fadvise(self._file.fileno(), self._asked, 2 * _AHEAD, os.POSIX_FADV_WILLNEED)
        self._asked += 2 * _AHEAD

    def _is_at_hand(self, at: int) -> bool:
        """Tell whether the system says that nobody would wait for a byte, which is quicker than advice."""
        if not hasattr(os, "RWF_NOWAIT"):
            return False
        try:
            os.preadv(self._file.fileno(), [bytearray(1)], at, os.RWF_NOWAIT)
        except OSError:
            return False
        return True


class Stream:
    """A file that holds its mosaic as it is.

    Parameters
    ----------
    frame
        Which; one that ``streams``.
    room
        Memory for a strip of it, and for the rows above.
    told
        Told of its hash once it has been read.
    above
        Rows above a strip that are kept with it.

    Raises
    ------
    OSError
        The file cannot be opened.

    """

    def __init__(self, frame: Frame, room: NDArray[np.uint8], told: Told, *, above: int = 0) -> None:
        self.frame = frame
        self._room = room.data
        self._told = told
        self._above = above
        self._held = 0
        self._top = mosaic_at(frame.header) or 0
        self._row_bytes, self._height = 2 * frame.header.width, frame.header.height
        self._file = HashedFile(frame.header)

    @property
    def complete(self) -> bool:
        """Tell whether the file has all its pixels."""
        return self._file.holds(self._top + self._height * self._row_bytes)

    def read(self, strip: Band) -> int:
        """Read a strip into the room, below the rows above; return the row that the room begins with.

        Strips follow each other from the top.

        Raises
        ------
        LostFrameError
            The file cannot be read, or has become shorter.

        """
        try:
            if strip.top == 0:
                self._file.pass_over(self._top)
            above = min(self._above, strip.top)
            kept = above * self._row_bytes
            if kept:
                self._room[:kept] = self._room[self._held - kept : self._held]
            self._held = kept + (strip.bottom - strip.top) * self._row_bytes
            self._file.read(self._room[kept : self._held])
            if strip.bottom == self._height:
                self._file.pass_over()
                self._told(self.frame, self._file.hash)
        except (RawFileError, OSError) as error:
            raise LostFrameError(self.frame, error) from error
        return strip.top - above

    def close(self) -> None:
        """Let the file go."""
        self._file.close()


def _ended() -> UnreadableFileError:
    return UnreadableFileError("file-truncated", "the file ends before its pixels do; copy it again")
