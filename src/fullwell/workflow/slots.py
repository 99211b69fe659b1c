"""Raw files are read into memory that is used again and again."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.moments import Stack
from fullwell.raw.open import decode

_LINE: Final = 64
_PIECE: Final = 1 << 18


class Slots:
    """A block of memory with room for some files, where each becomes a mosaic.

    Parameters
    ----------
    slots
        Files that fit at once.
    slot_bytes
        Room for the largest file, and for the largest mosaic.
    height, width
        Size of every frame's visible mosaic [pixel].

    """

    def __init__(self, *, slots: int, slot_bytes: int, height: int, width: int) -> None:
        self.slot_bytes = -(-slot_bytes // _LINE) * _LINE
        self._block = np.empty(slots * self.slot_bytes, np.uint8)
        self._codes = self._block.view(np.uint16)
        self._shape = (height, width)
        self._compressed: NDArray[np.uint8] | None = None
        self._starts: list[int] = []
        self.names: list[str] = []
        self.hashes: dict[str, str] = {}

    @property
    def full(self) -> bool:
        """Return whether no further file fits."""
        return (len(self._starts) + 1) * self.slot_bytes > self._block.nbytes

    def read(self, frame: Frame) -> None:
        """Read a file, hash it and decode it; a file that fails takes no room.

        Raises
        ------
        OSError
            The file cannot be read.
        RawFileError
            The file cannot be decoded.

        """
        first = len(self._starts) * self.slot_bytes
        slot = self._block[first : first + self.slot_bytes]
        stored = slot if frame.header.compression == "none" else self._apart()
        data, self.hashes[frame.name] = _read_into(frame.header.path, stored.data)
        target = slot[: 2 * self._shape[0] * self._shape[1]].view(np.uint16).reshape(self._shape)
        mosaic = decode(frame.header, data, out=None if stored is slot else target)
        if mosaic.shape != self._shape:
            raise UnreadableFileError("file-damaged", "the file changed its size while it was read; copy it again")
        self._starts.append(self._place(mosaic, first))
        self.names.append(frame.name)

    def _apart(self) -> NDArray[np.uint8]:
        """Return memory for a file whose mosaic is decoded into its slot, taken once."""
        if self._compressed is None:
            self._compressed = np.empty(self.slot_bytes, np.uint8)
        return self._compressed

    def stack(self) -> Stack:
        """Return the mosaics as they lie."""
        codes = self._codes.view()
        codes.flags.writeable = False
        return Stack(codes, np.array(self._starts, dtype=np.int64), self._shape[1])

    def clear(self) -> None:
        """Make room for other files; the hashes stay."""
        self._starts.clear()
        self.names.clear()

    def _place(self, mosaic: NDArray[np.uint16], first: int) -> int:
        """Return where in the block a mosaic begins [code], after copying it there unless it is there already."""
        offset = int(mosaic.__array_interface__["data"][0]) - int(self._block.__array_interface__["data"][0])
        if first <= offset < first + self.slot_bytes and offset % 2 == 0 and mosaic.flags.c_contiguous:
            return offset // 2
        start = first // 2
        target = self._codes[start : start + mosaic.size].reshape(mosaic.shape)
        np.copyto(target, mosaic)
        return start


def _read_into(path: Path, slot: memoryview) -> tuple[memoryview, str]:
    """Read a whole file into a slot, or into memory of its own if it has outgrown the slot; and return its hash.

    Pieces are hashed while they are still in the cache.
    """
    digest = xxh3_128()
    at = 0
    with path.open("rb", buffering=0) as file:
        while at < len(slot) and (count := file.readinto(slot[at : at + _PIECE])):
            digest.update(slot[at : at + count])
            at += count
        rest = file.read() if at == len(slot) else b""
    digest.update(rest)
    return (memoryview(bytes(slot) + rest) if rest else slot[:at]), digest.hexdigest()
