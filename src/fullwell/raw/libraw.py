"""LibRaw's view of a raw file: the door to rawpy."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError
from fullwell.raw.cfa import MONO

_COLOURS: Final = "RGBG"


@dataclass(frozen=True, slots=True, kw_only=True)
class LibRawImage:
    """What LibRaw says of a raw file, in Fullwell's order of sites.

    Parameters
    ----------
    mosaic
        Visible mosaic, ``uint16``, shape (height, width) [DN].
    cfa
        Order at the visible top-left pixel, or ``mono``.
    black_level
        Per site, row-major, as whole numbers: LibRaw rounds [DN].
    white_level
        [DN].
    iso, exposure_s
        None where LibRaw says 0.

    """

    mosaic: NDArray[np.uint16]
    cfa: str
    black_level: tuple[float, ...]
    white_level: float
    iso: float | None
    exposure_s: float | None


def read_with_libraw(path: Path) -> LibRawImage:
    """Return a raw file as LibRaw decodes it.

    LibRaw numbers its colours R, G1, B, G2 = 0, 1, 2, 3 with G1 and G2 wherever they fall, lists black levels by
    that number, and its ``raw_pattern`` counts from the visible top-left pixel.

    Raises
    ------
    UnreadableFileError
        ``not-a-raw-file`` where LibRaw does not open it.

    """
    import rawpy  # noqa: PLC0415 - loads when used

    try:
        with rawpy.imread(str(path)) as raw:
            pattern = raw.raw_pattern
            numbers = [0] if pattern is None or pattern.size != 4 else [int(number) for number in pattern.ravel()]
            return LibRawImage(
                mosaic=np.array(raw.raw_image_visible, dtype=np.uint16),
                cfa="".join(_COLOURS[number] for number in numbers) if len(numbers) == 4 else MONO,
                black_level=tuple(float(raw.black_level_per_channel[number]) for number in numbers),
                white_level=float(raw.white_level),
                iso=float(raw.other.iso_speed) or None,
                exposure_s=float(raw.other.shutter_speed) or None,
            )
    except rawpy.LibRawError as error:
        raise UnreadableFileError("not-a-raw-file", f"LibRaw does not read it ({error})") from error
