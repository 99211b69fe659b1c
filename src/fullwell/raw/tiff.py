"""What a plain TIFF file says about its mosaics, one a page: no levels, and a CFA only where its tags say so."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from fullwell.errors import UnsuitableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.directory import Directories, Directory
from fullwell.raw.dng import mosaic_cfa, raw_image
from fullwell.raw.exposure import read_exposure
from fullwell.raw.image import Area, Extent, RawHeader
from fullwell.raw.segments import Layout, read_layout
from fullwell.raw.tags import Compression, Photometric, Tag, compression_name

_DECODED: Final = (
    Compression.NONE,
    Compression.LZW,
    Compression.DEFLATE,
    Compression.OLD_DEFLATE,
    Compression.PACKBITS,
)
_FORM: Final = (
    Tag.NEW_SUBFILE_TYPE,
    Tag.IMAGE_WIDTH,
    Tag.IMAGE_LENGTH,
    Tag.BITS_PER_SAMPLE,
    Tag.PHOTOMETRIC,
    Tag.SAMPLES_PER_PIXEL,
    Tag.COMPRESSION,
)
"""What pages that are frames of one series have in common."""
_GREY: Final = (Photometric.BLACK_IS_ZERO, Photometric.CFA, Photometric.LINEAR_RAW)


def read_tiff_headers(path: Path, directories: Directories) -> tuple[RawHeader, ...]:
    """Return the header of every page of a TIFF file with one sample per pixel.

    A page is a frame where it is stored as the first is; smaller pictures and other pages are left out, with a finding.

    Raises
    ------
    UnsuitableFileError
        ``processed-rgb``, ``lossy-compression``, ``unsupported-compression``, ``unsupported-cfa``,
        ``unsupported-sample-format``.
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    image = raw_image(directories)
    _require_suitable(image)
    whole = _header(path, directories, image)
    if image is not directories.first:
        return (whole,)
    alike = [page for page in directories.following if _form(page) == _form(image)]
    others = sum(page.integer(Tag.NEW_SUBFILE_TYPE, 0) == 0 for page in directories.following) - len(alike)
    if others:
        message = f"{others} pages of the TIFF file are no frames like its first; they are left out."
        whole = replace(whole, findings=(Finding(code="pages-left-out", severity=Severity.WARNING, message=message),))
    if not alike:
        return (whole,)
    pages = (whole, *(_header(path, replace(directories, first=page), page) for page in alike))
    return tuple(_as_page(header, number) for number, header in enumerate(pages, start=1))


def _header(path: Path, directories: Directories, image: Directory) -> RawHeader:
    layout = read_layout(image, byte_order=directories.byte_order, file_size=directories.size)
    exposure = read_exposure(directories, image)
    return RawHeader(
        path=path,
        format="tiff",
        raw_width=layout.width,
        raw_height=layout.height,
        active_area=Area(0, 0, layout.height, layout.width),
        cfa=mosaic_cfa(image),
        bit_depth=image.integer(Tag.BITS_PER_SAMPLE, layout.bits),
        iso=exposure.iso,
        exposure_s=exposure.exposure_s,
        temperature_c=exposure.temperature_c,
        make=exposure.make,
        model=exposure.model,
        serial=exposure.serial,
        firmware=exposure.firmware,
        orientation=exposure.orientation,
        compression=compression_name(layout.compression),
        layout=layout,
    )


def _form(page: Directory) -> tuple[object, ...]:
    return tuple(page.numbers(tag) for tag in _FORM)


def _as_page(header: RawHeader, number: int) -> RawHeader:
    """Return a page's header, its pixels counted from the first byte of them."""
    layout = header.layout
    if not isinstance(layout, Layout):
        raise TypeError("the header is not that of a TIFF file")
    start = min(layout.offsets)
    stop = max(offset + count for offset, count in zip(layout.offsets, layout.stored_bytes, strict=True))
    moved = replace(layout, offsets=tuple(offset - start for offset in layout.offsets))
    return replace(header, page=number, extent=Extent(start, stop), layout=moved)


def _require_suitable(image: Directory) -> None:
    photometric = image.integer(Tag.PHOTOMETRIC, Photometric.BLACK_IS_ZERO)
    compression = image.integer(Tag.COMPRESSION, Compression.NONE)
    if compression in {Compression.OLD_JPEG, Compression.JPEG, Compression.LOSSY_JPEG}:
        raise UnsuitableFileError("lossy-compression", "the image is JPEG; use raw frames instead")
    if photometric == Photometric.WHITE_IS_ZERO:
        raise UnsuitableFileError("processed-rgb", "the image is stored inverted (WhiteIsZero); use raw frames instead")
    if image.integer(Tag.SAMPLES_PER_PIXEL, 1) != 1 or photometric not in _GREY:
        raise UnsuitableFileError("processed-rgb", "the image is in colour, not a mosaic; use raw frames instead")
    if compression not in _DECODED:
        name = compression_name(compression)
        raise UnsuitableFileError("unsupported-compression", f"the image is coded as {name}, which is not read")
    if photometric == Photometric.CFA and mosaic_cfa(image) is None:
        raise UnsuitableFileError("unsupported-cfa", "the colour-filter array is not one of the four Bayer orders")
