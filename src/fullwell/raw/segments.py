"""Where the pixels of a TIFF or DNG image lie, how they are stored, and whether the file has them all."""

from dataclasses import dataclass
from typing import Final

from fullwell.errors import UnreadableFileError, UnsuitableFileError
from fullwell.raw.directory import Directory
from fullwell.raw.tags import Compression, Tag

MAX_PIXELS: Final = 1_000_000_000
_MAX_EXPANSION: Final = 1100
"""No lossless coding met here packs more than about 1030 bytes into one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """How a one-sample image is stored.

    Parameters
    ----------
    width, height
        Size of the stored image [pixel].
    bits
        Bits per stored sample: 8 and 16 as whole bytes, any other depth up to 15 packed, first bit highest.
    byte_order
        ``<`` or ``>``, of 16-bit samples.
    compression, predictor
        The TIFF tags' values.
    segment_width, segment_height
        Size of a tile, or of a strip; the last strip may be lower, edge tiles are padded [pixel].
    tiled
        Whether segments are tiles.
    offsets, counts
        Position and length of each segment in the file, row-major [byte].
    row_interleave, column_interleave
        DNG interleave factors; 1 where pixels are stored in their own order.
    table
        DNG LinearizationTable: stored code to linear value; empty where absent.

    """

    width: int
    height: int
    bits: int
    byte_order: str
    compression: int
    predictor: int
    segment_width: int
    segment_height: int
    tiled: bool
    offsets: tuple[int, ...]
    counts: tuple[int, ...]
    row_interleave: int = 1
    column_interleave: int = 1
    table: tuple[int, ...] = ()

    @property
    def across(self) -> int:
        """Segments side by side."""
        return -(-self.width // self.segment_width)

    def rows(self, segment: int) -> int:
        """Return the rows a segment stores: its full height, but for the last strip."""
        if self.tiled:
            return self.segment_height
        return min(self.segment_height, self.height - segment * self.segment_height)

    @property
    def stored_bytes(self) -> tuple[int, ...]:
        """Return the bytes of each segment that are read, whatever the file says of uncompressed ones [byte]."""
        if self.compression != Compression.NONE:
            return self.counts
        return tuple(self.row_bytes * self.rows(segment) for segment in range(len(self.offsets)))

    @property
    def row_bytes(self) -> int:
        """Bytes of one uncompressed segment row; rows begin at whole bytes."""
        return (self.segment_width * self.bits + 7) // 8


def image_size(image: Directory) -> tuple[int, int]:
    """Return width and height of a directory's image [pixel].

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where there are none, or more than a gigapixel.

    """
    width, height = image.integer(Tag.IMAGE_WIDTH, 0), image.integer(Tag.IMAGE_LENGTH, 0)
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        raise UnreadableFileError("file-damaged", f"an image of {width} x {height} pixels cannot be right")
    return width, height


def read_layout(image: Directory, *, byte_order: str, file_size: int) -> Layout:
    """Return the layout of an image, checked against the file's size before anything is allocated.

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` where pixels lie beyond the end of the file, ``file-damaged`` where sizes contradict.
    UnsuitableFileError
        ``unsupported-sample-format`` where samples are not unsigned integers of at most 16 bits.

    """
    width, height = image_size(image)
    tiled = Tag.TILE_OFFSETS in image
    segment_width = image.integer(Tag.TILE_WIDTH, 0) if tiled else width
    segment_height = image.integer(Tag.TILE_LENGTH, 0) if tiled else image.integer(Tag.ROWS_PER_STRIP, height)
    if not tiled:
        segment_height = min(segment_height, height)
    if segment_width <= 0 or segment_height <= 0 or segment_width * segment_height > MAX_PIXELS:
        raise UnreadableFileError("file-damaged", f"segments of {segment_width} x {segment_height} cannot be right")
    offsets = image.integers(Tag.TILE_OFFSETS if tiled else Tag.STRIP_OFFSETS)
    counts = image.integers(Tag.TILE_BYTE_COUNTS if tiled else Tag.STRIP_BYTE_COUNTS)
    compression = image.integer(Tag.COMPRESSION, Compression.NONE)
    layout = Layout(
        width=width,
        height=height,
        bits=_stored_bits(image, compression=compression, samples=segment_width * segment_height, counts=counts),
        byte_order=byte_order,
        compression=compression,
        predictor=image.integer(Tag.PREDICTOR, 1),
        segment_width=segment_width,
        segment_height=segment_height,
        tiled=tiled,
        offsets=offsets,
        counts=counts,
        row_interleave=image.integer(Tag.ROW_INTERLEAVE_FACTOR, 1),
        column_interleave=image.integer(Tag.COLUMN_INTERLEAVE_FACTOR, 1),
        table=image.integers(Tag.LINEARIZATION_TABLE),
    )
    _check(layout, file_size=file_size)
    return layout


def _stored_bits(image: Directory, *, compression: int, samples: int, counts: tuple[int, ...]) -> int:
    bits = image.integer(Tag.BITS_PER_SAMPLE, 1)
    if image.integer(Tag.SAMPLE_FORMAT, 1) != 1 or not 8 <= bits <= 16:
        raise UnsuitableFileError(
            "unsupported-sample-format", f"samples are not unsigned integers of 8 to 16 bits (BitsPerSample {bits})"
        )
    if image.integer(Tag.FILL_ORDER, 1) != 1 and bits not in {8, 16}:
        raise UnsuitableFileError("unsupported-sample-format", "packed samples with FillOrder 2 are not supported")
    in_words = compression == Compression.NONE and bits > 8 and counts[:1] == (2 * samples,)
    return 16 if in_words else bits


def _check(layout: Layout, *, file_size: int) -> None:
    expected = layout.across * -(-layout.height // layout.segment_height)
    if not (len(layout.offsets) == len(layout.counts) == expected):
        raise UnreadableFileError(
            "file-damaged",
            f"{expected} segments are needed, {len(layout.offsets)} offsets and {len(layout.counts)} sizes are given",
        )
    if not (1 <= layout.row_interleave <= layout.height and 1 <= layout.column_interleave <= layout.width):
        raise UnreadableFileError("file-damaged", "the interleave factors are larger than the image")
    if any(not 0 <= value <= 65535 for value in layout.table):
        raise UnreadableFileError("file-damaged", "the LinearizationTable holds values beyond 16 bits")
    for segment, (offset, count) in enumerate(zip(layout.offsets, layout.counts, strict=True)):
        plain = layout.compression == Compression.NONE
        needed = layout.row_bytes * layout.rows(segment) if plain else count
        if offset + needed > file_size:
            missing = offset + needed - file_size
            raise UnreadableFileError(
                "file-truncated", f"the file ends {missing} bytes before its pixels do; copy it again"
            )
        if layout.segment_width * layout.rows(segment) > 8 * _MAX_EXPANSION * max(needed, 1):
            raise UnreadableFileError("file-damaged", f"segment {segment} has {count} bytes, too few for its pixels")
