"""Raw files are read into memory that is used again and again."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.stack import Stack
from fullwell.raw.image import RawHeader
from fullwell.raw.open import decode
from fullwell.statistics.batch import Batch
from fullwell.statistics.moments import Layout

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
    layout
        Size of every frame's visible mosaic.

    """

    def __init__(self, *, slots: int, slot_bytes: int, layout: Layout) -> None:
        self.slot_bytes = -(-slot_bytes // _LINE) * _LINE
        self._block = np.empty(slots * self.slot_bytes, np.uint8)
        self._codes = self._block.view(np.uint16)
        self._shape = (layout.height, layout.width)
        self._compressed: NDArray[np.uint8] | None = None
        self._starts: list[int] = []
        self._places: dict[str, int] = {}

    def fits(self, files: int) -> bool:
        """Return whether there is room for so many more."""
        return (len(self._starts) + files) * self.slot_bytes <= self._block.nbytes

    @property
    def empty(self) -> bool:
        """Return whether there is no mosaic."""
        return not self._starts

    def read(self, frame: Frame, hashes: dict[str, str]) -> None:
        """Read a file, hash it and decode it; a file that fails takes no room.

        Parameters
        ----------
        frame
            The file.
        hashes
            Where its hash is put, by name, once it has been read; also if it cannot be decoded then.

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
        data, hashes[frame.name] = _read_into(frame.header, stored.data)
        target = slot[: 2 * self._shape[0] * self._shape[1]].view(np.uint16).reshape(self._shape)
        mosaic = decode(frame.header, data, out=None if stored is slot else target)
        if mosaic.shape != self._shape:
            raise UnreadableFileError("file-damaged", "the file changed its size while it was read; copy it again")
        self._places[frame.name] = len(self._starts)
        self._starts.append(self._place(mosaic, first))

    def _apart(self) -> NDArray[np.uint8]:
        """Return memory for a file whose mosaic is decoded into its slot, taken once."""
        if self._compressed is None:
            self._compressed = np.empty(self.slot_bytes, np.uint8)
        return self._compressed

    def batch(self, groups: Sequence[Sequence[Frame]] = ()) -> Batch:
        """Return the mosaics as they lie; pairs are the groups of two of which both are there."""
        codes = self._codes.view()
        codes.flags.writeable = False
        at = self._places
        return Batch(
            tuple(at),
            Stack(codes, np.array(self._starts, dtype=np.int64), self._shape[1]),
            pairs=[
                (at[group[0].name], at[group[1].name])
                for group in groups
                if len(group) == 2 and all(frame.name in at for frame in group)
            ],
        )

    def clear(self) -> None:
        """Make room for other files."""
        self._starts.clear()
        self._places.clear()

    def _place(self, mosaic: NDArray[np.uint16], first: int) -> int:
        """Return where in the block a mosaic begins [code], after copying it there unless it is there already."""
        offset = int(mosaic.__array_interface__["data"][0]) - int(self._block.__array_interface__["data"][0])
        if first <= offset < first + self.slot_bytes and offset % 2 == 0 and mosaic.flags.c_contiguous:
            return offset // 2
        start = first // 2
        target = self._codes[start : start + mosaic.size].reshape(mosaic.shape)
        np.copyto(target, mosaic)
        return start


def _read_into(header: RawHeader, slot: memoryview) -> tuple[memoryview, str]:
    """Read a frame's bytes into a slot, or into memory of its own if it has outgrown the slot; and return its hash.

    Pieces are hashed while they are still in the cache.
    """
    digest = xxh3_128()
    at = 0
    start, stop = header.extent or (0, None)
    slot = slot if stop is None else slot[: stop - start]
    with header.path.open("rb", buffering=0) as file:
        file.seek(start)
        while at < len(slot) and (count := file.readinto(slot[at : at + _PIECE])):
            digest.update(slot[at : at + count])
            at += count
        rest = file.read() if at == len(slot) and stop is None else b""
    digest.update(rest)
    return (memoryview(bytes(slot) + rest) if rest else slot[:at]), digest.hexdigest()


def hash_of(header: RawHeader) -> str:
    """Return the hash of a frame's bytes, without keeping them.

    Raises
    ------
    OSError
        The file cannot be read.

    """
    digest = xxh3_128()
    piece = memoryview(bytearray(_PIECE))
    start, stop = header.extent or (0, None)
    with header.path.open("rb", buffering=0) as file:
        at = file.seek(start)
        while (stop is None or at < stop) and (
            count := file.readinto(piece if stop is None else piece[: min(_PIECE, stop - at)])
        ):
            digest.update(piece[:count])
            at += count
    return digest.hexdigest()
