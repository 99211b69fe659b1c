"""A second reader beside ours: what LibRaw makes of a raw file, without anything of Fullwell's between."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rawpy
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LibRawImage:
    """The visible mosaic, its order, and levels per site from its top-left pixel [DN]; None where LibRaw says 0."""

    mosaic: NDArray[np.uint16]
    cfa: str
    black_level: tuple[float, ...]
    white_level: float
    iso: float | None
    exposure_s: float | None


def read_with_libraw(path: Path) -> LibRawImage:
    with rawpy.imread(str(path)) as raw:
        pattern = raw.raw_pattern
        numbers = [0] if pattern is None or pattern.size != 4 else pattern.ravel().tolist()
        colours = raw.color_desc.decode("ascii")
        return LibRawImage(
            mosaic=np.array(raw.raw_image_visible, np.uint16),
            cfa="".join(colours[number] for number in numbers) if len(numbers) == 4 else "mono",
            black_level=tuple(float(raw.black_level_per_channel[number]) for number in numbers),
            white_level=float(raw.white_level),
            iso=float(raw.other.iso_speed) or None,
            exposure_s=float(raw.other.shutter_speed) or None,
        )
