"""What a DNG file says about its mosaic.

Origin of the patterns. The DNG specification says of BlackLevel that "the origin of this pattern is the top-left
corner of the ActiveArea rectangle". Of CFAPattern it does not say so in words, but the readers that matter count it
from the same corner: Adobe's own crops to the ActiveArea before it applies the pattern, RawSpeed states it in its
decoder, and LibRaw, which moves an odd origin to the next even row and column, shifts the CFA by just that step (the
tests show it; it leaves the black levels unshifted then, against the specification). So both patterns are read as they
stand, for the visible mosaic; what shifts with an odd ActiveArea is the phase of the *stored* frame, margins included:
``shifted(cfa, rows=-top, columns=-left)``.
"""

import math
from pathlib import Path
from typing import Final

from fullwell.errors import UnreadableFileError
from fullwell.findings import Finding, Severity
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.directory import Directories, Directory
from fullwell.raw.exposure import read_exposure
from fullwell.raw.image import D65, Area, ColourMatrix, RawHeader
from fullwell.raw.levels import declared_levels
from fullwell.raw.lossless_jpeg import is_dct
from fullwell.raw.segments import image_size, read_layout
from fullwell.raw.tags import Compression, Photometric, Tag, compression_name

_LETTERS: Final = "RGB"
_DECODED: Final = ("none", "lossless-jpeg", "deflate", "jpeg-xl")
_JPEG_HEADER_BYTES: Final = 4096


def read_dng_header(path: Path, directories: Directories) -> RawHeader:
    """Return the header of a DNG file.

    A file that must not be measured (lossy, linear RGB, an unknown CFA) has a header all the same: it says why in a
    finding of severity ``error`` and has no layout.

    Raises
    ------
    UnreadableFileError
        ``file-truncated`` or ``file-damaged``.

    """
    image = raw_image(directories)
    width, height = image_size(image)
    compression = _compression(path, image)
    cfa = _cfa(image)
    unsuitable = _unsuitable(image, cfa=cfa, compression=compression)
    layout = None
    if not unsuitable:
        layout = read_layout(image, byte_order=directories.byte_order, file_size=directories.size)
    area = _active_area(image, width=width, height=height)
    masked, masked_findings = _masked_areas(image, width=width, height=height)
    levels = declared_levels(image, cfa=cfa or MONO, active_area=area)
    exposure = read_exposure(directories, image)
    profile = directories.lookup(Tag.NOISE_PROFILE, image).numbers(Tag.NOISE_PROFILE)
    return RawHeader(
        path=path,
        format="dng",
        raw_width=width,
        raw_height=height,
        active_area=area,
        cfa=cfa,
        bit_depth=image.integer(Tag.BITS_PER_SAMPLE, 1),
        black_level=levels.black,
        white_level=levels.white,
        iso=exposure.iso,
        exposure_s=exposure.exposure_s,
        temperature_c=exposure.temperature_c,
        make=exposure.make,
        model=exposure.model,
        serial=exposure.serial,
        firmware=exposure.firmware,
        orientation=exposure.orientation,
        compression=compression,
        masked_areas=masked,
        noise_profile=tuple(zip(profile[0::2], profile[1::2], strict=False)),
        as_shot_neutral=_neutral(directories, image),
        colour_matrix=_colour_matrix(directories, image),
        level_tags=levels.tags,
        layout=layout,
        findings=unsuitable + levels.findings + masked_findings,
    )


def raw_image(directories: Directories) -> Directory:
    """Return the main image's directory: full resolution before previews, a mosaic before anything else."""

    def rank(directory: Directory) -> tuple[bool, bool, bool, int]:
        photometric = directory.integer(Tag.PHOTOMETRIC, -1)
        return (
            directory.integer(Tag.NEW_SUBFILE_TYPE, 0) == 0,
            photometric == Photometric.CFA,
            photometric == Photometric.LINEAR_RAW,
            directory.integer(Tag.IMAGE_WIDTH, 0) * directory.integer(Tag.IMAGE_LENGTH, 0),
        )

    return max((directories.first, *directories.subs), key=rank)


def mosaic_cfa(image: Directory) -> str | None:
    """Return the Bayer order that CFARepeatPatternDim and CFAPattern declare; None for any other pattern."""
    pattern = image.integers(Tag.CFA_PATTERN)
    if image.integers(Tag.CFA_REPEAT_PATTERN_DIM) != (2, 2) or not all(0 <= colour < 3 for colour in pattern):
        return None
    order = "".join(_LETTERS[colour] for colour in pattern)
    return order if order in BAYER else None


def _cfa(image: Directory) -> str | None:
    if image.integer(Tag.PHOTOMETRIC, -1) == Photometric.CFA:
        return mosaic_cfa(image)
    return MONO if image.integer(Tag.SAMPLES_PER_PIXEL, 1) == 1 else None


def _compression(path: Path, image: Directory) -> str:
    code = image.integer(Tag.COMPRESSION, Compression.NONE)
    if code == Compression.JPEG and not _is_lossless_jpeg(path, image):
        return "lossy-jpeg"
    if code == Compression.JPEG_XL and image.number(Tag.JXL_DISTANCE) != 0.0:
        return "lossy-jpeg-xl"
    return compression_name(code)


def _is_lossless_jpeg(path: Path, image: Directory) -> bool:
    offsets = image.integers(Tag.TILE_OFFSETS) or image.integers(Tag.STRIP_OFFSETS)
    if not offsets:
        return True
    with path.open("rb") as file:
        file.seek(offsets[0])
        return not is_dct(file.read(_JPEG_HEADER_BYTES))


def _unsuitable(image: Directory, *, cfa: str | None, compression: str) -> tuple[Finding, ...]:
    """Return why the image must not be measured, as findings of severity ``error``."""
    reasons: list[tuple[str, str]] = []
    if compression.startswith("lossy-"):
        reasons.append(("lossy-compression", f"the raw image is {compression}; lossy coding changes its noise"))
    elif compression not in _DECODED:
        reasons.append(("unsupported-compression", f"the raw image is coded as {compression}, which is not read"))
    if image.integer(Tag.SAMPLES_PER_PIXEL, 1) != 1:
        reasons.append(("linear-dng", "the raw image is demosaiced (LinearRaw); its noise is no longer the sensor's"))
    elif cfa is None:
        reasons.append(("unsupported-cfa", "the colour-filter array is not one of the four Bayer orders"))
    return tuple(
        Finding(code=code, severity=Severity.ERROR, message=f"It cannot be measured: {message}.")
        for code, message in reasons
    )


def _neutral(directories: Directories, image: Directory) -> tuple[float, ...]:
    """Return AsShotNeutral where it is three positive numbers."""
    values = directories.lookup(Tag.AS_SHOT_NEUTRAL, image).numbers(Tag.AS_SHOT_NEUTRAL)
    return values if len(values) == 3 and all(math.isfinite(value) and value > 0.0 for value in values) else ()


def _colour_matrix(directories: Directories, image: Directory) -> ColourMatrix | None:
    """Return the matrix for daylight, else the first that has nine numbers."""
    found: list[ColourMatrix] = []
    for tag, light in (
        (Tag.COLOR_MATRIX_1, Tag.CALIBRATION_ILLUMINANT_1),
        (Tag.COLOR_MATRIX_2, Tag.CALIBRATION_ILLUMINANT_2),
    ):
        values = directories.lookup(tag, image).numbers(tag)
        if len(values) == 9 and all(map(math.isfinite, values)):
            found.append(ColourMatrix(values, directories.lookup(light, image).integer(light, 0)))
    return next((one for one in found if one.illuminant == D65), found[0] if found else None)


def _active_area(image: Directory, *, width: int, height: int) -> Area:
    if Tag.ACTIVE_AREA not in image:
        return Area(0, 0, height, width)
    corners = image.integers(Tag.ACTIVE_AREA)
    if len(corners) != 4 or not _inside(area := Area(*corners), width=width, height=height):
        raise UnreadableFileError("file-damaged", f"ActiveArea {corners} does not lie within {width} x {height}")
    return area


def _masked_areas(image: Directory, *, width: int, height: int) -> tuple[tuple[Area, ...], tuple[Finding, ...]]:
    corners = image.integers(Tag.MASKED_AREAS)
    areas = tuple(Area(*corners[first : first + 4]) for first in range(0, len(corners) - 3, 4))
    kept = tuple(area for area in areas if _inside(area, width=width, height=height))
    if len(kept) * 4 == len(corners):
        return kept, ()
    message = "MaskedAreas names rectangles outside the frame; they are not used."
    return kept, (Finding(code="masked-areas-damaged", severity=Severity.WARNING, message=message),)


def _inside(area: Area, *, width: int, height: int) -> bool:
    return 0 <= area.top < area.bottom <= height and 0 <= area.left < area.right <= width
