"""Find a chart's patches in a mosaic."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.chart.definition import ChartDefinition
from fullwell.frames.chart.patches import Patch

CONFIDENCE: Final = 0.5
"""Below it a location is refused."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Located:
    """Where a chart is.

    Parameters
    ----------
    patches
        What to measure; empty where nothing was found.
    confidence
        0 to 1; below `CONFIDENCE` the caller refuses, with ``reason``.
    corners
        x, y of the chart's corners, clockwise from the chart's own top left [pixel]; empty where nothing was found.
    orientation
        Clockwise turn of the chart in the frame, to the nearest quarter [degree].
    reason
        A sentence that says why the location is not trusted, empty where it is.

    """

    patches: tuple[Patch, ...]
    confidence: float
    corners: tuple[Point, ...]
    orientation: int
    reason: str = ""


def locate(
    mosaic: NDArray[np.uint16],
    *,
    cfa: str,
    black: float,
    white: float,
    definition: ChartDefinition,
    corners: tuple[Point, Point, Point, Point] | None = None,
) -> Located:
    """Return where a chart's patches are."""
    raise NotImplementedError
