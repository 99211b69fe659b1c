"""DNG files, written so that LibRaw and Fullwell read the same mosaic, levels and CFA back."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import BAYER, MONO, cell
from fullwell.raw.fields import Field, FieldType, text
from fullwell.raw.image import D65, Area, ColourMatrix
from fullwell.raw.opcodes import GainMap, OpcodeList, opcode_bytes
from fullwell.raw.tags import Compression, Photometric, Tag
from fullwell.raw.tiff_file import exif_fields, long, short, tiff_parts, write_whole

_DEFAULT_TILE: Final = 512
XYZ_TO_SRGB: Final = (3.2405, -1.5371, -0.4985, -0.9693, 1.8760, 0.0416, 0.0556, -0.2040, 1.0572)
"""The camera's colours are taken for linear sRGB where nothing better is known (IEC 61966-2-1)."""
_LINEAR_SRGB: Final = ColourMatrix(XYZ_TO_SRGB, D65)


@dataclass(frozen=True, slots=True, kw_only=True)
class DngExtras:
    """What a DNG may say beyond the usual; all optional.

    Parameters
    ----------
    active_area
        Visible mosaic in coordinates of the stored one; all of it by default.
    masked_areas
        Optical-black rectangles, in the same coordinates.
    noise_profile
        (S, O) per colour plane, or one pair for all.
    linearization_table
        Linear value of each stored code.
    black_level_delta_h, black_level_delta_v
        Added to the black level, per column and per row of the active area [DN].
    orientation
        TIFF tag Orientation.
    temperature_c
        EXIF tag Temperature [deg C].
    gain_maps
        Opcodes of OpcodeList2, which readers apply after black is subtracted.
    as_shot_neutral
        What white is in the camera's own R, G and B; 1, 1, 1 by default.
    colour_matrix
        The camera's; where it is None, its colours are taken for linear sRGB.

    """

    active_area: Area | None = None
    masked_areas: tuple[Area, ...] = ()
    noise_profile: tuple[tuple[float, float], ...] = ()
    linearization_table: tuple[int, ...] = ()
    black_level_delta_h: tuple[float, ...] = ()
    black_level_delta_v: tuple[float, ...] = ()
    orientation: int = 1
    temperature_c: float | None = None
    gain_maps: tuple[GainMap, ...] = ()
    as_shot_neutral: tuple[float, ...] = ()
    colour_matrix: ColourMatrix | None = None


def write_dng(
    path: Path,
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    black_level: Sequence[float] | None,
    white_level: int | None,
    bit_depth: int = 16,
    iso: float | None = None,
    exposure_s: float | None = None,
    compression: Literal["none", "lossless-jpeg"] = "none",
    tile: tuple[int, int] | None = None,
    make: str = "Fullwell",
    model: str = "Fullwell simulated camera",
    extras: DngExtras | None = None,
) -> None:
    """Write a mosaic as a DNG file: beside its target first, then renamed, so that no half file is ever seen.

    Parameters
    ----------
    path
        The file; one that exists is replaced.
    mosaic
        The stored mosaic, margins included, ``uint16``, shape (height, width) [DN].
    cfa
        Order at the visible top-left pixel, or ``mono``.
    black_level
        One value, or one per CFA site, row-major from the visible top-left pixel; None leaves the tag out, for which
        readers take 0 [DN].
    white_level
        Saturated code; None leaves the tag out, for which readers take the highest code of the stored bits [DN].
    bit_depth
        Bits of the codes. Uncompressed samples take 8 bits where this is 8, 16 otherwise.
    iso, exposure_s
        ISO speed (a whole number) and exposure time [-, s].
    compression
        ``none`` or ``lossless-jpeg``.
    tile
        Height and width of tiles, multiples of 16 and no larger than the mosaic (LibRaw misreads lossless tiles that
        are); by default one strip, or tiles of 512 where a compressed mosaic is large enough.
    make, model
        Names of the camera.
    extras
        Whatever else the file shall say.

    Raises
    ------
    ValueError
        Where the arguments contradict each other.

    """
    extras = extras or DngExtras()
    _require_consistent(mosaic, cfa=cfa, black_level=black_level, bit_depth=bit_depth, tile=tile)
    segments, stored_as = _segments(mosaic, bit_depth=bit_depth, compression=compression, tile=tile, cfa=cfa)
    fields = [
        *stored_as,
        *_image_fields(mosaic, cfa=cfa),
        *_level_fields(cfa=cfa, black_level=black_level, white_level=white_level),
        *camera_fields(cfa=cfa, make=make, model=model, extras=extras),
        *_extra_fields(extras),
    ]
    exif = exif_fields(iso=iso, exposure_s=exposure_s, temperature_c=extras.temperature_c)
    write_whole(path, tiff_parts(fields, exif, segments))


def _require_consistent(
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    black_level: Sequence[float] | None,
    bit_depth: int,
    tile: tuple[int, int] | None,
) -> None:
    if mosaic.dtype != np.uint16 or mosaic.ndim != 2 or mosaic.size == 0:
        raise ValueError(f"the mosaic must be a two-dimensional uint16 array, not {mosaic.dtype} of {mosaic.shape}")
    if cfa not in (*BAYER, MONO):
        raise ValueError(f"cfa must be one of {', '.join((*BAYER, MONO))}, not {cfa!r}")
    if black_level is not None and len(black_level) not in {1, cell(cfa) ** 2}:
        raise ValueError(f"{len(black_level)} black levels do not fit a {cfa} mosaic")
    if not 8 <= bit_depth <= 16 or int(mosaic.max()) >= 1 << bit_depth:
        raise ValueError(f"codes up to {mosaic.max()} do not fit {bit_depth} bits (8 to 16)")
    if tile is not None and any(side % 16 or not 16 <= side <= mosaic.shape[axis] for axis, side in enumerate(tile)):
        raise ValueError(f"height and width of a tile must be multiples of 16 within the mosaic, not {tile}")


def _segments(
    mosaic: NDArray[np.uint16],
    *,
    bit_depth: int,
    compression: str,
    tile: tuple[int, int] | None,
    cfa: str,
) -> tuple[Sequence[bytes | memoryview], list[Field]]:
    """Return the stored segments and the fields that say how they are stored."""
    height, width = mosaic.shape
    compressed = compression == "lossless-jpeg"
    if compressed and tile is None and min(height, width) >= _DEFAULT_TILE:
        tile = (_DEFAULT_TILE, _DEFAULT_TILE)
    dtype = np.uint8 if bit_depth == 8 else np.dtype("<u2")
    fields = [
        short(Tag.COMPRESSION, Compression.JPEG if compressed else Compression.NONE),
        short(Tag.BITS_PER_SAMPLE, bit_depth if compressed or bit_depth == 8 else 16),
    ]
    if tile is None:
        fields.append(long(Tag.ROWS_PER_STRIP, height))
        if compressed:
            return [_lossless(mosaic, bit_depth=bit_depth, cfa=cfa)], fields
        return [np.ascontiguousarray(mosaic, dtype=dtype).data.cast("B")], fields
    fields += [long(Tag.TILE_LENGTH, tile[0]), long(Tag.TILE_WIDTH, tile[1])]
    tiles = (
        _tile(mosaic[top : top + tile[0], left : left + tile[1]], tile)
        for top in range(0, height, tile[0])
        for left in range(0, width, tile[1])
    )
    if compressed:
        return [_lossless(block, bit_depth=bit_depth, cfa=cfa) for block in tiles], fields
    return [block.astype(dtype).tobytes() for block in tiles], fields


def _tile(block: NDArray[np.uint16], tile: tuple[int, int]) -> NDArray[np.uint16]:
    """Return a block at the full size of a tile; reflection pads like colours with like."""
    missing = [(0, tile[axis] - block.shape[axis]) for axis in (0, 1)]
    return np.pad(block, missing, mode="reflect") if block.shape != tile else block


def _lossless(block: NDArray[np.uint16], *, bit_depth: int, cfa: str) -> bytes:
    """Return a block as lossless JPEG: two rows of a Bayer block as one line of two components.

    Left and above are then the nearest samples of the same colour.
    """
    from fullwell.raw.lossless_jpeg_writing import encode_lossless  # noqa: PLC0415 - loads the JIT when used

    height, width = block.shape
    paired = cfa != MONO and height % 2 == 0 and width % 2 == 0
    lines = block.reshape(height // 2, width, 2) if paired else block.reshape(height, width, 1)
    return encode_lossless(np.ascontiguousarray(lines), precision=bit_depth, predictor=7)


def _image_fields(mosaic: NDArray[np.uint16], *, cfa: str) -> list[Field]:
    height, width = mosaic.shape
    fields = [
        long(Tag.NEW_SUBFILE_TYPE, 0),
        long(Tag.IMAGE_WIDTH, width),
        long(Tag.IMAGE_LENGTH, height),
        short(Tag.SAMPLES_PER_PIXEL, 1),
        short(Tag.PLANAR_CONFIGURATION, 1),
        short(Tag.PHOTOMETRIC, Photometric.LINEAR_RAW if cfa == MONO else Photometric.CFA),
    ]
    if cfa != MONO:
        fields += [
            *pattern_fields(cfa),
            Field(tag=Tag.CFA_PLANE_COLOR, type=FieldType.BYTE, values=(0, 1, 2)),
            short(Tag.CFA_LAYOUT, 1),
        ]
    return fields


def pattern_fields(cfa: str) -> list[Field]:
    """Return the fields of TIFF/EP that tell a Bayer order."""
    return [
        short(Tag.CFA_REPEAT_PATTERN_DIM, 2, 2),
        Field(tag=Tag.CFA_PATTERN, type=FieldType.BYTE, values=["RGB".index(letter) for letter in cfa]),
    ]


def _level_fields(*, cfa: str, black_level: Sequence[float] | None, white_level: int | None) -> list[Field]:
    fields: list[Field] = []
    if black_level is not None:
        period = cell(cfa) if len(black_level) > 1 else 1
        whole = all(float(level).is_integer() for level in black_level)
        kind = FieldType.LONG if whole else FieldType.RATIONAL
        fields.append(short(Tag.BLACK_LEVEL_REPEAT_DIM, period, period))
        fields.append(Field(tag=Tag.BLACK_LEVEL, type=kind, values=black_level))
    if white_level is not None:
        fields.append(long(Tag.WHITE_LEVEL, white_level))
    return fields


def camera_fields(*, cfa: str, make: str, model: str, extras: DngExtras) -> list[Field]:
    """Return the fields that make a TIFF file a DNG, and tell its camera."""
    fields = [
        Field(tag=Tag.DNG_VERSION, type=FieldType.BYTE, values=(1, 4, 0, 0)),
        Field(tag=Tag.DNG_BACKWARD_VERSION, type=FieldType.BYTE, values=(1, 1, 0, 0)),
        text(Tag.MAKE, make),
        text(Tag.MODEL, model),
        text(Tag.UNIQUE_CAMERA_MODEL, model),
        text(Tag.SOFTWARE, "Fullwell"),
        short(Tag.ORIENTATION, extras.orientation),
    ]
    if cfa != MONO:
        matrix = extras.colour_matrix or _LINEAR_SRGB
        fields += [
            Field(tag=Tag.COLOR_MATRIX_1, type=FieldType.SRATIONAL, values=matrix.values),
            Field(tag=Tag.AS_SHOT_NEUTRAL, type=FieldType.RATIONAL, values=extras.as_shot_neutral or (1, 1, 1)),
            short(Tag.CALIBRATION_ILLUMINANT_1, matrix.illuminant),
        ]
    return fields


def _extra_fields(extras: DngExtras) -> list[Field]:
    fields: list[Field] = []
    if extras.active_area is not None:
        fields.append(long(Tag.ACTIVE_AREA, *extras.active_area))
    if extras.masked_areas:
        fields.append(long(Tag.MASKED_AREAS, *(corner for area in extras.masked_areas for corner in area)))
    if extras.noise_profile:
        pairs = [value for pair in extras.noise_profile for value in pair]
        fields.append(Field(tag=Tag.NOISE_PROFILE, type=FieldType.DOUBLE, values=pairs))
    if extras.linearization_table:
        fields.append(short(Tag.LINEARIZATION_TABLE, *extras.linearization_table))
    for tag, delta in (
        (Tag.BLACK_LEVEL_DELTA_H, extras.black_level_delta_h),
        (Tag.BLACK_LEVEL_DELTA_V, extras.black_level_delta_v),
    ):
        if delta:
            fields.append(Field(tag=tag, type=FieldType.SRATIONAL, values=delta))
    if extras.gain_maps:
        encoded = opcode_bytes(extras.gain_maps)
        fields.append(Field(tag=OpcodeList.OPCODE_LIST_2, type=FieldType.UNDEFINED, values=encoded))
    return fields
