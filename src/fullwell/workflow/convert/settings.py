"""What a conversion is asked to do."""

from dataclasses import dataclass
from typing import Final, Literal

FileKind = Literal["dng", "tiff"]
Compression = Literal["none", "lossless-jpeg"]

KINDS: Final[tuple[FileKind, ...]] = ("dng", "tiff")
COMPRESSIONS: Final[tuple[Compression, ...]] = ("none", "lossless-jpeg")
MOST_SHIFT: Final = 15
"""Bits that codes can be shifted by, to either side."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """Settings of a conversion; as they stand here, every code stays what it is.

    Parameters
    ----------
    compression
        Of DNG mosaics.
    linearize
        Black becomes 0 and white 65535, per CFA site.
    demosaic
        Three colours at every pixel, linear; black becomes 0 and white 65535.
    white_balance
        Colours are scaled so that what was neutral becomes grey; black becomes 0 and white 65535.
    bit_shift
        Bits that codes are shifted by before all else: to the left above 0, to the right below.
    overwrite
        Whether files that exist may be replaced; a file that is read never is.

    """

    compression: Compression = "none"
    linearize: bool = False
    demosaic: bool = False
    white_balance: bool = False
    bit_shift: int = 0
    overwrite: bool = False

    @property
    def rescales(self) -> bool:
        """Return whether black becomes 0 and white 65535."""
        return self.linearize or self.demosaic or self.white_balance
