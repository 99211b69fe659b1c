"""The front door for raw files: what a file is decides who reads it, its name does not.

A file that bears no sign of its format is headerless, and read as the caller says, or as the preset for its extension.

Which function: `read_header` for what a file says about itself (fast, no pixels), `read_headers` for a file of many
frames, `read_bytes` for what `decode` makes a mosaic of, `read_raw` for both at once, `require_measurable` before noise
is measured.
"""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError, UnreadableFileError, UnsuitableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.decode import SegmentRows, coded_at, decode_segments, rows_at, segment_rows
from fullwell.raw.directory import read_directories
from fullwell.raw.dng import read_dng_header
from fullwell.raw.fits import SIGNATURE as FITS_SIGNATURE
from fullwell.raw.fits import decode_fits, read_fits_headers
from fullwell.raw.headerless import decode_headerless, read_headerless_header
from fullwell.raw.headerless_format import HeaderlessFormat
from fullwell.raw.image import Area, RawHeader, RawImage
from fullwell.raw.maker import MakerLayout, decode_maker, is_maker, read_maker_header
from fullwell.raw.netpbm import SIGNATURES as NETPBM_SIGNATURES
from fullwell.raw.netpbm import decode_netpbm, read_netpbm_header
from fullwell.raw.numpy_file import SIGNATURE as NUMPY_SIGNATURE
from fullwell.raw.numpy_file import decode_numpy, read_numpy_headers
from fullwell.raw.png import SIGNATURE as PNG_SIGNATURE
from fullwell.raw.png import decode_png, read_png_header
from fullwell.raw.presets import STANDARD_EXTENSIONS, preset_for
from fullwell.raw.segments import Layout
from fullwell.raw.tags import Tag
from fullwell.raw.tiff import read_tiff_headers

_TIFF_SIGNATURES: Final = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_JPEG_SIGNATURE: Final = b"\xff\xd8\xff"
_HEAD_BYTES: Final = 64
_NO_RAW: Final = ("not-a-raw-file", "unsupported-camera")
"""What LibRaw says of a picture that is no raw file."""
_DECODERS: Final = {"fits": decode_fits, "npy": decode_numpy, "pgm": decode_netpbm}


def read_header(path: Path, *, headerless: HeaderlessFormat | None = None, said_by: str = "--headerless") -> RawHeader:
    """Return what a raw file says about itself, without its pixels; of a file of many frames, the first one's.

    A file that can be parsed but must not be measured has a header too, with the reason as a finding of severity
    ``error``; see `require_measurable`.

    Parameters
    ----------
    path
        The file.
    headerless
        How the file is stored if it has no header; None asks the presets.
    said_by
        Who says so, for the finding that tells it.

    Raises
    ------
    UnreadableFileError
        ``file-missing``, ``file-unreadable``, ``not-a-raw-file``, ``file-truncated``, ``file-damaged``,
        ``decoder-failed``, ``geometry-mismatch``.
    UnsuitableFileError
        ``lossy-compression``, ``processed-rgb``, ``unsupported-compression``, ``unsupported-cfa``,
        ``unsupported-sample-format``, ``unsupported-camera``.

    """
    headers = read_headers(path, headerless=headerless, said_by=said_by)
    first = headers[0]
    if len(headers) == 1:
        return first
    message = (
        f"It holds {len(headers)} frames; this is the first. In a study each is a frame of its own: {path.name}#1 ..."
    )
    finding = Finding(code="several-frames", severity=Severity.INFO, message=message)
    return replace(first, findings=(*first.findings, finding))


def read_headers(
    path: Path, *, headerless: HeaderlessFormat | None = None, said_by: str = "--headerless"
) -> tuple[RawHeader, ...]:
    """Return the header of every frame of a file: the pages of a TIFF, the planes of a FITS cube or of an array.

    Parameters, errors: as `read_header`.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
            size = file.seek(0, 2)
        known = _read_headers(path, head=head, size=size)
        return known or (_read_headerless(path, size=size, stated=headerless, said_by=said_by),)
    except FileNotFoundError as error:
        raise UnreadableFileError("file-missing", "the file does not exist") from error
    except OSError as error:
        raise UnreadableFileError("file-unreadable", f"the file cannot be read ({error.strerror})") from error


def read_bytes(header: RawHeader) -> memoryview:
    """Return the bytes of a file that `decode` makes the mosaic of.

    They lie in memory of NumPy's, which comes in large pages: in small ones it takes longer to come by than to fill.

    Raises
    ------
    OSError
        The file cannot be read.

    """
    with header.path.open("rb", buffering=0) as file:
        start, stop = header.extent or (0, file.seek(0, 2))
        file.seek(start)
        memory = np.empty(stop - start, np.uint8).data
        at = 0
        while at < len(memory) and (count := file.readinto(memory[at:])):
            at += count
    return memory[:at].toreadonly()


def _read_headers(path: Path, *, head: bytes, size: int) -> tuple[RawHeader, ...]:
    """Return the headers of a file whose content, or extension, tells its format; none for any other."""
    if size == 0:
        raise UnreadableFileError("file-truncated", "the file is empty; copy it again")
    if is_maker(path, head) and not head.startswith(_JPEG_SIGNATURE):
        return (read_maker_header(path),)
    if head.startswith(_TIFF_SIGNATURES):
        if _directory_start(head) + 2 > size:
            raise UnreadableFileError("file-truncated", "the file ends before its directory; copy it again")
        return _read_tiff_like(path)
    if head.startswith(PNG_SIGNATURE):
        return (read_png_header(path, head, size),)
    if head.startswith(_JPEG_SIGNATURE):
        raise UnsuitableFileError("lossy-compression", "this is a JPEG file; use the camera's raw files instead")
    return _read_array_headers(path, head=head, size=size)


def _read_tiff_like(path: Path) -> tuple[RawHeader, ...]:
    """Return the headers of a DNG, a plain TIFF, or a maker's raw file by another name."""
    directories = read_directories(path)
    if Tag.DNG_VERSION in directories.first:
        return (read_dng_header(path, directories),)
    try:
        return read_tiff_headers(path, directories)
    except UnsuitableFileError as error:
        if directories.first.text(Tag.MAKE) is None:
            raise
        try:
            return (read_maker_header(path),)
        except RawFileError as other:
            raise (error if other.code in _NO_RAW else other) from None


def _read_array_headers(path: Path, *, head: bytes, size: int) -> tuple[RawHeader, ...]:
    """Return the headers of a format that holds arrays of any kind; none where it is none of them."""
    if head.startswith(FITS_SIGNATURE):
        return read_fits_headers(path, size)
    if head.startswith(NUMPY_SIGNATURE):
        return read_numpy_headers(path, size)
    if head.startswith(NETPBM_SIGNATURES) and head[2:3].isspace():
        return (read_netpbm_header(path, size),)
    return ()


def _read_headerless(path: Path, *, size: int, stated: HeaderlessFormat | None, said_by: str) -> RawHeader:
    preset = None if stated is not None else preset_for(path)
    if stated is not None:
        return read_headerless_header(path, stated, size=size, source=said_by)
    if preset is not None:
        return read_headerless_header(path, preset, size=size, source=f"the preset for {path.suffix.lower()}")
    sentence = "this is not a raw file of a kind Fullwell reads"
    if path.suffix.lower().removeprefix(".") not in STANDARD_EXTENSIONS:
        sentence += (
            "; if it holds pixels without a header, say how they are stored with --headerless width=...,height=..., "
            "or see what `fullwell inspect FILE --guess` makes of it"
        )
    raise UnreadableFileError("not-a-raw-file", sentence)


def _directory_start(head: bytes) -> int:
    """Return where a TIFF file says its first directory begins; 0 where the file ends before that."""
    order = "little" if head.startswith(b"II") else "big"
    return int.from_bytes(head[8:16] if b"+" in head[:4] else head[4:8], order)


def require_measurable(header: RawHeader) -> None:
    """Refuse a file whose header says that it must not be measured.

    Raises
    ------
    UnsuitableFileError
        With code and message of the header's first finding of severity ``error``.

    """
    for finding in header.findings:
        if finding.severity is Severity.ERROR:
            raise UnsuitableFileError(finding.code, finding.message)


def mosaic_at(header: RawHeader) -> int | None:
    """Return where in a frame's bytes its visible mosaic lies, row after row in the machine's own 16-bit words.

    None where the mosaic must be decoded, or must not be measured [byte].
    """
    layout = _usable_layout(header)
    return None if layout is None else rows_at(layout, header.active_area)


def mosaic_coded_at(header: RawHeader) -> slice | None:
    """Return where in a frame's bytes lies the lossless JPEG that its visible mosaic is; None where it is not one."""
    layout = _usable_layout(header)
    return None if layout is None else coded_at(layout, header.active_area)


def segment_rows_of(header: RawHeader) -> SegmentRows | None:
    """Return where in a frame's bytes rows of segments lie that can be decoded one after the other, if it has such."""
    layout = _usable_layout(header)
    return None if layout is None else segment_rows(layout)


def decode_rows(
    header: RawHeader, data: memoryview, rows: tuple[int, int], *, first_byte: int, out: NDArray[np.uint16]
) -> None:
    """Decode some rows of the visible mosaic of a file that has `segment_rows_of`.

    Parameters
    ----------
    header
        The file's header.
    data
        Bytes of the frame in which the segments of these rows lie.
    rows
        The first, and one past the last.
    first_byte
        Place of ``data`` in the frame.
    out
        Where they go, shape (rows, header.width), C-contiguous [DN].

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `decode`.

    """
    layout = _usable_layout(header)
    if layout is None:
        raise ValueError(f"a {header.format} file is not decoded by rows")
    moved = replace(layout, offsets=tuple(offset - first_byte for offset in layout.offsets))
    area, (first, last) = header.active_area, rows
    decode_segments(moved, data, Area(area.top + first, area.left, area.top + last, area.right), out=out)


def _usable_layout(header: RawHeader) -> Layout | None:
    """Return where the segments of a file lie; None where there are none, or where it must not be measured."""
    refused = any(finding.severity is Severity.ERROR for finding in header.findings)
    return header.layout if isinstance(header.layout, Layout) and not refused else None


def decode(
    header: RawHeader, data: bytes | bytearray | memoryview, *, out: NDArray[np.uint16] | None = None
) -> NDArray[np.uint16]:
    """Return the visible mosaic of a raw file that is already in memory.

    Parameters
    ----------
    header
        The file's header.
    data
        All bytes of the file, or what `read_bytes` returns.
    out
        Memory for the mosaic, shape (header.height, header.width), C-contiguous, apart from ``data``; used where
        samples are not stored the way they are returned.

    Returns
    -------
    ndarray
        Array of ``uint16``, shape (header.height, header.width), C-contiguous and read-only; never clipped at black,
        a LinearizationTable applied. A view of ``data`` where samples are stored that way, or of ``out`` [DN].

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``; for headerless files ``geometry-mismatch`` or ``geometry-wrong``.
    UnsuitableFileError
        As `require_measurable`.

    """
    require_measurable(header)
    view = memoryview(data).cast("B")
    if header.extent is not None and len(view) != header.extent.stop - header.extent.start:
        view = view[header.extent.start : header.extent.stop]
    if isinstance(header.layout, Layout):
        mosaic = decode_segments(header.layout, view, header.active_area, out=out)
    elif isinstance(header.layout, HeaderlessFormat):
        mosaic = decode_headerless(header.layout, view, out=out)
    elif isinstance(header.layout, MakerLayout):
        mosaic = decode_maker(header, view, out=out)
    elif header.format == "png":
        mosaic = decode_png(header, view, out=out)
    else:
        mosaic = _DECODERS[header.format](header, view)
    mosaic = mosaic.view()
    mosaic.flags.writeable = False
    return mosaic


def read_raw(path: Path, *, headerless: HeaderlessFormat | None = None) -> RawImage:
    """Return a raw file's visible mosaic with its header; ``headerless`` as in `read_header`.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        As `read_header` and `decode`.

    """
    header = read_header(path, headerless=headerless)
    return RawImage(header=header, mosaic=decode(header, read_bytes(header)))
