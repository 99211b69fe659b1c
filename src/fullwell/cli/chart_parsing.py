"""Texts of ``fullwell chart`` become values."""

import math
from collections.abc import Sequence
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.workflow.chart.patches import Corners, WhereAbouts
from fullwell.workflow.measure.chart.chart import BlackChoice

LEGACY = "legacy-offset-ratio"
_CORNERS = 4


def where_from(patches: Sequence[Path] | None, chart: str | None, corners: str | None) -> WhereAbouts:
    """Return where the patches are to be found.

    Raises
    ------
    UsageError
        Where neither patches nor a chart are given, or both.

    """
    if patches and chart:
        raise UsageError("Give --patches or --chart, not both: one says where patches are, the other looks for them.")
    if not patches and not chart:
        raise UsageError(
            "Say where the patches are: --patches PATCHES.csv, or --chart NAME to have them found "
            "(`fullwell chart --guide` tells how to shoot)."
        )
    if corners is not None and not chart:
        raise UsageError("--corners are those of a chart: name it with --chart.")
    return WhereAbouts(
        patches=tuple(patches or ()), chart=chart, corners=None if corners is None else corners_from(corners)
    )


def corners_from(text: str) -> Corners:
    """Return four points from eight numbers.

    Examples
    --------
    >>> corners_from("0,0,10,0,10,5,0,5")
    ((0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 5.0))

    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 2 * _CORNERS or not all(math.isfinite(number) for number in numbers):
        raise UsageError(
            f"--corners {text}: give x1,y1,x2,y2,x3,y3,x4,y4 in pixels of the visible mosaic, clockwise from the "
            "chart's own top left."
        )
    first, second, third, fourth = zip(numbers[::2], numbers[1::2], strict=True)
    return first, second, third, fourth


def black_choice_from(text: str | None) -> BlackChoice:
    """Return how the black level is to be set.

    Examples
    --------
    >>> black_choice_from("legacy-offset-ratio=1e4").ratio
    10000.0

    """
    if text is None:
        return BlackChoice()
    name, given, number = text.partition("=")
    ratio: float | None = None
    if given:
        try:
            ratio = float(number)
        except ValueError:
            ratio = math.nan
    if name != LEGACY or (ratio is not None and not 1.0 < ratio < math.inf):
        raise UsageError(
            f"--black-method {text}: give {LEGACY}, or {LEGACY}=R with the ratio R of the lightest to the darkest "
            "patch, above 1. Without it all evidence of the shots is used."
        )
    return BlackChoice(legacy=True, ratio=ratio)
