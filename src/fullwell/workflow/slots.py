"""Raw files are read into memory that is used again and again: as mosaics strip by strip where possible, or whole."""

from collections.abc import Iterable, Sequence
from threading import Event
from typing import Final

import numpy as np
from numpy.typing import NDArray
from xxhash import xxh3_128

from fullwell.errors import UnreadableFileError
from fullwell.frames.series import Frame
from fullwell.kernels.high_pass import REACH
from fullwell.kernels.stack import Band, Stack
from fullwell.raw.image import RawHeader
from fullwell.raw.open import decode, segment_rows_of
from fullwell.statistics.batch import Batch
from fullwell.statistics.moments import Layout
from fullwell.workflow.coded_stream import (
    CodedMemory,
    CodedStream,
    DecodedStream,
    SegmentStream,
    coded_stream,
    decodes,
    room_bytes,
)
from fullwell.workflow.memory import in_large_pages
from fullwell.workflow.stream import Stream, Told, streams

AnyStream = Stream | CodedStream | DecodedStream | SegmentStream

MOST_FRAMES: Final = 16
"""Files that are open at once: the more, the more rarely sums go to memory and back, until strips leave the cache."""
_LINE: Final = 64
"""Of the cache: where files and mosaics begin [byte]."""
_PIECE: Final = 1 << 18
"""Read and hashed in one go, so that it is still in the cache [byte]."""


def passes(frame: Frame) -> bool:
    """Tell whether a frame's mosaic need not be in memory as a whole."""
    return streams(frame) or decodes(frame)


def slot_bytes_to_pass(frames: Iterable[Frame], layout: Layout) -> int:
    """Return the memory that each of some files needs which all ``pass``."""
    return max((room_bytes(frame, layout) for frame in frames if not streams(frame)), default=layout.strip_bytes)


class StoppedError(Exception):
    """The work is called off."""


class Slots:
    """A block of memory with room for some files, where each becomes a mosaic.

    Parameters
    ----------
    slots
        Files that fit at once.
    slot_bytes
        Room for the largest file, and for the largest mosaic; or `slot_bytes_to_pass`, where all pass strip by strip.
    layout
        Size of every frame's visible mosaic.
    stop
        Set where what is under way shall end.

    """

    def __init__(self, *, slots: int, slot_bytes: int, layout: Layout, stop: Event | None = None) -> None:
        self.slot_bytes = _in_lines(slot_bytes)
        self._layout = layout
        self._block = in_large_pages(slots * self.slot_bytes)
        self._codes = self._block.view(np.uint16)
        self._shape = (layout.height, layout.width)
        self._stop = stop
        self._compressed: NDArray[np.uint8] | None = None
        self._used = 0
        self._places: dict[str, int] = {}
        self._starts: list[int] = []
        self._streams: list[tuple[int, AnyStream]] = []
        self._coded: list[CodedMemory] = []

    def fits(self, files: int) -> bool:
        """Return whether there is room for so many more."""
        enough = self._used + files * self.slot_bytes <= self._block.nbytes
        return enough and len(self._starts) + files <= MOST_FRAMES

    @property
    def empty(self) -> bool:
        """Return whether there is no mosaic."""
        return not self._starts

    def read(self, frame: Frame, told: Told, *, whole: bool = False, two: bool = False) -> None:
        """Read a file, hash it and decode it, or open it to be read when it is added; one that fails takes no room.

        Parameters
        ----------
        frame
            The file.
        told
            Told of its hash once it has been read; also if it cannot be decoded then.
        whole
            Whether all of its mosaic must be there at once.
        two
            Whether it is one of two frames that are added by `two_frames.add_two`: in parts, where its file holds its
            mosaic as it is, else as a whole.

        Raises
        ------
        OSError
            The file cannot be read.
        RawFileError
            The file cannot be decoded.

        """
        if not whole and streams(frame) and self._open(frame, told, two=two):
            return
        whole = whole or two
        if not whole and decodes(frame):
            self._decode(frame, told)
            return
        if self.slot_bytes < 2 * self._shape[0] * self._shape[1]:
            self._decode_apart(frame, told)
            return
        first = self._used
        slot = self._block[first : first + self.slot_bytes]
        stored = slot if frame.header.compression == "none" else self._apart()
        data, digest = _read_into(frame.header, stored.data)
        told(frame, digest)
        target = slot[: 2 * self._shape[0] * self._shape[1]].view(np.uint16).reshape(self._shape)
        mosaic = self._checked(decode(frame.header, data, out=None if stored is slot else target))
        self._take(frame, start=self._place(mosaic, first), size=self.slot_bytes)

    def _open(self, frame: Frame, told: Told, *, two: bool) -> bool:
        """Open a file to be read strip by strip; a file that has lost some of its pixels is better read as a whole."""
        layout = self._layout
        above = REACH * layout.cell if two else 0
        rows = layout.part_rows if two else layout.strip_rows
        size = _in_lines(2 * layout.width * (above + rows))
        stream = Stream(frame, self._block[self._used : self._used + size], told, above=above)
        if not stream.complete:
            stream.close()
            return False
        self._pass(stream, size=size)
        return True

    def _decode(self, frame: Frame, told: Told) -> None:
        """Read a file that is decoded some rows at a time, or open it to be read when it is added."""
        while len(self._coded) <= len(self._starts):
            self._coded.append(CodedMemory())
        memory = self._coded[len(self._starts)]
        size = _in_lines(room_bytes(frame, self._layout))
        if segment_rows_of(frame.header) is None:
            data, digest = _read_into(frame.header, memory.take(frame.size))
            told(frame, digest)
            self._pass(coded_stream(frame, data, self._room(size), self._layout), size=size)
            return
        stream = SegmentStream(frame, memory, self._room(size), told)
        if stream.complete:
            self._pass(stream, size=size)
        else:
            stream.close()
            self._decode_apart(frame, told)

    def _decode_apart(self, frame: Frame, told: Told) -> None:
        """Read and decode a file in memory of its own, where there is none for its mosaic here."""
        data, digest = _read_into(frame.header, memoryview(bytearray(frame.size)))
        told(frame, digest)
        size = _in_lines(self._layout.strip_bytes)
        mosaic = self._checked(decode(frame.header, data))
        self._pass(DecodedStream(frame, mosaic, self._room(size)), size=size)

    def _room(self, size: int) -> NDArray[np.uint16]:
        return self._codes[self._used // 2 : (self._used + size) // 2]

    def _pass(self, stream: AnyStream, *, size: int) -> None:
        self._streams.append((len(self._starts), stream))
        self._take(stream.frame, start=self._used // 2, size=size)

    def _checked(self, mosaic: NDArray[np.uint16]) -> NDArray[np.uint16]:
        if mosaic.shape != self._shape:
            raise UnreadableFileError("file-damaged", "the file changed its size while it was read; copy it again")
        return mosaic

    def _take(self, frame: Frame, *, start: int, size: int) -> None:
        self._places[frame.name] = len(self._starts)
        self._starts.append(start)
        self._used += size

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
        return _Passing(
            tuple(at),
            Stack(codes, np.array(self._starts, dtype=np.int64), self._shape[1]),
            streams=tuple(self._streams),
            stop=self._stop,
            pairs=[
                (at[group[0].name], at[group[1].name])
                for group in groups
                if len(group) == 2 and all(frame.name in at for frame in group)
            ],
        )

    def clear(self) -> None:
        """Make room for other files."""
        for _place, stream in self._streams:
            stream.close()
        self._streams.clear()
        self._used = 0
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


class _Passing(Batch):
    """Frames some of which are read while they are added.

    Parameters
    ----------
    names, stack, pairs
        As in `Batch`; a frame that is read while it is added begins where its strips come to lie.
    streams
        Such frames: place in the stack, and file.
    stop
        Set where reading shall end.

    """

    def __init__(
        self,
        names: Sequence[str],
        stack: Stack,
        *,
        pairs: Sequence[tuple[int, int]],
        streams: Sequence[tuple[int, AnyStream]],
        stop: Event | None,
    ) -> None:
        super().__init__(names, stack, pairs=pairs)
        self._streams = streams
        self._stop = stop

    def rows(self, strip: Band) -> Stack:
        """Read a strip, from the top to the bottom, and return where it lies."""
        starts = self.stack.starts.copy()
        if self._stop is not None and self._stop.is_set():
            raise StoppedError
        for place, stream in self._streams:
            starts[place] -= stream.read(strip) * self.stack.width
        return Stack(self.stack.codes, starts, self.stack.width)


def _in_lines(size: int) -> int:
    """Return a size in whole lines of the cache."""
    return -(-size // _LINE) * _LINE


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
    start, stop = header.extent or (0, None)
    with header.path.open("rb", buffering=0) as file:
        at = file.seek(start)
        while piece := file.read(_PIECE if stop is None else min(_PIECE, stop - at)):
            digest.update(piece)
            at += len(piece)
    return digest.hexdigest()
