"""What the measurements of charts read: the patches of every scene at every exposure, grouped by ISO."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.chart.locate import Located
from fullwell.frames.chart.patches import Patch
from fullwell.statistics.chart import Cuts, PatchPoint
from fullwell.statistics.series import Histogram
from fullwell.workflow.masked import MaskedArea
from fullwell.workflow.measure.bursts import IsoBursts


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exposure:
    """Frames of one scene at one exposure.

    Parameters
    ----------
    exposure_s
        None where the files do not say [s].
    files
        Names of the frames.
    cuts
        What was taken out of each frame: the pixels of its patches.
    points
        Statistics of every patch and channel.

    """

    exposure_s: float | None
    files: tuple[str, ...]
    cuts: tuple[Cuts, ...]
    points: tuple[PatchPoint, ...]

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return len(self.files)

    def of(self, channel: str) -> tuple[PatchPoint, ...]:
        """Return the points of one channel, one per patch."""
        return tuple(point for point in self.points if point.channel == channel)

    @property
    def level_dn(self) -> float:
        """Return the mean of all patches, black level included [DN]."""
        return float(np.mean([point.mean_dn for point in self.points]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """One still scene: a chart that neither it nor the camera moved in front of.

    Parameters
    ----------
    name
        Of its first file.
    patches
        The same in all its frames.
    exposures
        The brightest first.
    located
        How the patches were found; None where they were given.
    image, image_step
        Visible mosaic of the brightest frame in squares of whole cells, the mean of each, shape (rows, columns) [DN];
        edge of a square [pixel].

    """

    name: str
    patches: tuple[Patch, ...]
    exposures: tuple[Exposure, ...]
    located: Located | None = None
    image: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    image_step: int = 1

    @property
    def brightest(self) -> Exposure:
        """Return the exposure with the highest level."""
        return self.exposures[0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shots:
    """Every scene at one ISO.

    Parameters
    ----------
    bursts
        Holds ISO, temperature and channels for the rows; no bursts of its own.
    cfa, width, height
        Of the visible mosaic.
    histograms
        Codes of the brightest frames, by channel.
    masked
        Masked pixels by channel; empty where the files have none.
    step_dn
        Distance of two codes that occur [DN].

    """

    bursts: IsoBursts
    scenes: tuple[Scene, ...]
    cfa: str
    width: int
    height: int
    histograms: tuple[Histogram, ...]
    masked: tuple[MaskedArea, ...] = ()
    step_dn: int = 1

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channels in the order of the CFA sites."""
        return self.bursts.channels

    @property
    def exposures(self) -> tuple[tuple[int, Exposure], ...]:
        """Return every exposure with the number of its scene."""
        return tuple((index, one) for index, scene in enumerate(self.scenes) for one in scene.exposures)

    @property
    def has_bursts(self) -> bool:
        """Tell whether any exposure has several frames."""
        return any(exposure.frames > 1 for _, exposure in self.exposures)

    def points(self, channel: str) -> tuple[PatchPoint, ...]:
        """Return the points of one channel, of all scenes and exposures."""
        return tuple(point for _, exposure in self.exposures for point in exposure.of(channel))


def holder(*, iso: float | None, temperature_c: float | None, channels: Sequence[str]) -> IsoBursts:
    """Return what a row writer needs to know of one ISO."""
    return IsoBursts(iso=iso, temperature_c=temperature_c, channels=tuple(channels), flats=(), darks=(), biases=())


def code_step(histograms: Iterable[Histogram]) -> int:
    """Return the distance of the codes that occur: the greatest common divisor of their differences (METHOD 0) [DN].

    Examples
    --------
    >>> code_step([Histogram(first_code=8, counts=np.array([3, 0, 0, 0, 5, 0, 0, 0, 1]), frames=1)])
    4

    """
    step = 0
    for histogram in histograms:
        codes = np.flatnonzero(histogram.counts)
        step = int(np.gcd.reduce(np.append(codes - codes[0], step))) if codes.size else step
    return max(step, 1)
