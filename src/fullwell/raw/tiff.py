"""What a plain TIFF file says about its mosaic: no levels, and a CFA only where its tags say so."""

from pathlib import Path
from typing import Final

from fullwell.errors import UnsuitableFileError
from fullwell.raw.directory import Directories, Directory
from fullwell.raw.dng import mosaic_cfa, raw_image
from fullwell.raw.exposure import read_exposure
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.segments import read_layout
from fullwell.raw.tags import Compression, Photometric, Tag, compression_name

_DECODED: Final = (
    Compression.NONE,
    Compression.LZW,
    Compression.DEFLATE,
    Compression.OLD_DEFLATE,
    Compression.PACKBITS,
)
_GREY: Final = (Photometric.BLACK_IS_ZERO, Photometric.CFA, Photometric.LINEAR_RAW)


def read_tiff_header(path: Path, directories: Directories) -> RawHeader:
    """Return the header of a TIFF file with one sample per pixel.

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
