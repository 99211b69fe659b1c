"""What the frames of one series come to."""

from collections.abc import Mapping
from dataclasses import dataclass

from fullwell.frames.series import Exclusion
from fullwell.statistics.first_look import FirstFrames
from fullwell.statistics.pixels import PixelSums
from fullwell.statistics.series import SeriesStatistics


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesOutcome:
    """A series, reduced.

    Parameters
    ----------
    statistics
        None where no frame is good.
    hashes
        xxh3-128 of every file that could be read, by frame name.
    excluded
        Frames that turned out to be damaged.
    sums
        Sum over the good frames of each pixel, shape (height, width), read-only [DN]; None where it is not kept.
    first
        What the first frames tell one by one; None where one is damaged, or they were not read together.

    """

    statistics: SeriesStatistics | None
    hashes: Mapping[str, str]
    excluded: tuple[Exclusion, ...] = ()
    sums: PixelSums | None = None
    first: FirstFrames | None = None
