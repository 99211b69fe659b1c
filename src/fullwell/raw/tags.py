"""TIFF, EXIF and DNG tags, by the names their specifications give them, and the codes that stand for values."""

from enum import IntEnum
from typing import Final


class Tag(IntEnum):
    """Tag codes of TIFF 6.0, TIFF/EP, EXIF 2.32 and DNG 1.7 that Fullwell reads or writes."""

    NEW_SUBFILE_TYPE = 254
    IMAGE_WIDTH = 256
    IMAGE_LENGTH = 257
    BITS_PER_SAMPLE = 258
    COMPRESSION = 259
    PHOTOMETRIC = 262
    FILL_ORDER = 266
    MAKE = 271
    MODEL = 272
    STRIP_OFFSETS = 273
    ORIENTATION = 274
    SAMPLES_PER_PIXEL = 277
    ROWS_PER_STRIP = 278
    STRIP_BYTE_COUNTS = 279
    PLANAR_CONFIGURATION = 284
    SOFTWARE = 305
    PREDICTOR = 317
    TILE_WIDTH = 322
    TILE_LENGTH = 323
    TILE_OFFSETS = 324
    TILE_BYTE_COUNTS = 325
    SUB_IFDS = 330
    SAMPLE_FORMAT = 339
    CFA_REPEAT_PATTERN_DIM = 33421
    CFA_PATTERN = 33422
    EXPOSURE_TIME = 33434
    EXIF_IFD = 34665
    ISO_SPEED_RATINGS = 34855
    SENSITIVITY_TYPE = 34864
    STANDARD_OUTPUT_SENSITIVITY = 34865
    RECOMMENDED_EXPOSURE_INDEX = 34866
    ISO_SPEED = 34867
    TEMPERATURE = 37888
    BODY_SERIAL_NUMBER = 42033
    DNG_VERSION = 50706
    DNG_BACKWARD_VERSION = 50707
    UNIQUE_CAMERA_MODEL = 50708
    CFA_PLANE_COLOR = 50710
    CFA_LAYOUT = 50711
    LINEARIZATION_TABLE = 50712
    BLACK_LEVEL_REPEAT_DIM = 50713
    BLACK_LEVEL = 50714
    BLACK_LEVEL_DELTA_H = 50715
    BLACK_LEVEL_DELTA_V = 50716
    WHITE_LEVEL = 50717
    COLOR_MATRIX_1 = 50721
    COLOR_MATRIX_2 = 50722
    AS_SHOT_NEUTRAL = 50728
    CAMERA_SERIAL_NUMBER = 50735
    CALIBRATION_ILLUMINANT_1 = 50778
    CALIBRATION_ILLUMINANT_2 = 50779
    ACTIVE_AREA = 50829
    MASKED_AREAS = 50830
    ROW_INTERLEAVE_FACTOR = 50975
    NOISE_PROFILE = 51041
    COLUMN_INTERLEAVE_FACTOR = 52547
    JXL_DISTANCE = 52553


class Compression(IntEnum):
    """Values of the tag Compression that Fullwell knows."""

    NONE = 1
    LZW = 5
    OLD_JPEG = 6
    JPEG = 7
    DEFLATE = 8
    VC_5 = 9
    OLD_DEFLATE = 32946
    PACKBITS = 32773
    LOSSY_JPEG = 34892
    JPEG_XL = 52546


class Photometric(IntEnum):
    """Values of the tag PhotometricInterpretation that matter here."""

    WHITE_IS_ZERO = 0
    BLACK_IS_ZERO = 1
    RGB = 2
    CFA = 32803
    LINEAR_RAW = 34892


ISO_TAGS: Final = (
    Tag.ISO_SPEED_RATINGS,
    Tag.ISO_SPEED,
    Tag.RECOMMENDED_EXPOSURE_INDEX,
    Tag.STANDARD_OUTPUT_SENSITIVITY,
)
"""Where EXIF has the ISO speed: the first that tells one counts."""
ISO_IN_OTHER_TAG: Final = 65535
"""EXIF 2.3: ISOSpeedRatings of this value means "see the other sensitivity tags"."""

COMPRESSION_NAMES: Final[tuple[tuple[Compression, str], ...]] = (
    (Compression.NONE, "none"),
    (Compression.LZW, "lzw"),
    (Compression.OLD_JPEG, "lossy-jpeg"),
    (Compression.JPEG, "lossless-jpeg"),
    (Compression.DEFLATE, "deflate"),
    (Compression.OLD_DEFLATE, "deflate"),
    (Compression.VC_5, "vc-5"),
    (Compression.PACKBITS, "packbits"),
    (Compression.LOSSY_JPEG, "lossy-jpeg"),
    (Compression.JPEG_XL, "jpeg-xl"),
)


def compression_name(code: int) -> str:
    """Return the name of a compression as `RawHeader.compression` has it.

    Examples
    --------
    >>> compression_name(1), compression_name(9999)
    ('none', 'tiff-9999')

    """
    return {int(known): name for known, name in COMPRESSION_NAMES}.get(code, f"tiff-{code}")
