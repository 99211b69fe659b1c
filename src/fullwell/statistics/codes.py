"""Which codes a plane uses, and which it never does: the code step, gaps of a scaled channel, missing codes (METHOD 0).

A converter of one code a step fills every code between its darkest and brightest ones. Codes that stay empty although
those around them are well filled tell what was done to the numbers afterwards: all at one distance, low bits that
nobody uses; at regular distances, a channel multiplied by a factor; wider and wider, a companding curve; anything else,
codes that the converter or a defect-free table leaves out. Codes filled twice as well at regular distances are the same
of a channel that was scaled down.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.series import Histogram

FOREGONE: Final = 25.0
"""Values that an empty code must be expected to hold before it is called missing: exp(-25) is 1e-11."""
EMPTY_SHARE: Final = 0.02
"""Of what is expected, from where down a code counts as empty: a few values are put there by later corrections."""
SLOW_DECLINE: Final = 0.7
"""Ratio of a code's values to those of the one before: peaks that fall faster have valleys between them."""
WINDOW: Final = 4
"""Filled codes on either side that foretell what lies between them."""
FEWEST_CODES: Final = 16
"""Filled codes in a row that a distance is judged on."""
FEWEST_GAPS: Final = 4
"""Gaps from where on regular distances are no accident."""
FEWEST_DOUBLED: Final = 6
DOUBLED: Final = 1.5
"""Times the median of the codes around from where on a code counts as filled twice."""
ENOUGH_TO_DOUBLE: Final = 700.0
"""Values of the codes around from where on chance hides or feigns no double: it is six standard errors off 1 and 2."""
WIDEST_GAP: Final = 16
"""Code steps beyond which nothing is foretold across a gap: it may part two peaks."""
COMPANDED: Final = 1.5
"""Ratio of the distances at both ends from where on a step is said to grow."""


class Pattern(StrEnum):
    """What the gaps of a histogram look like."""

    EVERY = "every"
    STEPPED = "stepped"
    SCALED_UP = "scaled-up"
    SCALED_DOWN = "scaled-down"
    COMPANDED = "companded"
    MISSING = "missing"


@dataclass(frozen=True, slots=True, kw_only=True)
class CodeUse:
    """How a plane uses its codes.

    Parameters
    ----------
    lowest, highest
        Extreme codes [DN].
    step
        Greatest common divisor of the distances between codes that occur [DN].
    pattern
        What the gaps look like.
    scale
        Distance of two codes of the converter in codes of the file: ``step``, or the factor of a scaled channel; 1
        where every code is used [DN].
    widest
        The largest distance of two codes that ought to be neighbours [DN].
    judged
        First and last code between which distances could be judged; None where too few codes are filled well enough.
    missing
        Codes that are empty though they should not be, the first of them [DN].
    n_missing
        How many there are.

    """

    lowest: int
    highest: int
    step: int
    pattern: Pattern
    scale: float
    widest: int
    judged: tuple[int, int] | None
    missing: tuple[int, ...] = ()
    n_missing: int = 0


MOST_LISTED: Final = 16
"""Missing codes that are named one by one."""


def code_use(histogram: Histogram) -> CodeUse:
    """Return how a plane uses its codes.

    Parameters
    ----------
    histogram
        Exact counts.

    Examples
    --------
    >>> counts = np.zeros(400, np.int64)
    >>> counts[np.round(1.25 * np.arange(320)).astype(int)] = 200
    >>> found = code_use(Histogram(first_code=100, counts=counts, frames=1))
    >>> found.pattern.value, round(found.scale, 3)
    ('scaled-up', 1.25)

    """
    codes = np.flatnonzero(histogram.counts)
    counts = histogram.counts[codes].astype(np.float64)
    lowest, highest = histogram.first_code + int(codes[0]), histogram.first_code + int(codes[-1])
    step = max(int(np.gcd.reduce(np.diff(codes))), 1) if codes.size > 1 else 1
    well = _well_filled(counts)
    runs = list(_runs(codes[well], counts[well], step))
    longest = max(runs, key=len, default=codes[:0])
    judged = longest.size >= FEWEST_CODES
    pattern, scale = _pattern(longest // step) if judged else (Pattern.EVERY, 1.0)
    if pattern is Pattern.EVERY and judged:
        pattern, scale = _doubled(longest, histogram.counts)
    missing = _missing(codes[well], counts[well], step) if pattern in {Pattern.EVERY, Pattern.MISSING} else []
    if pattern is Pattern.EVERY and missing:
        pattern = Pattern.MISSING
    elif pattern is Pattern.EVERY and step > 1 and judged:
        pattern = Pattern.STEPPED
    return CodeUse(
        lowest=lowest,
        highest=highest,
        step=step,
        pattern=pattern,
        scale=scale * step if judged else 1.0,
        widest=int(np.diff(longest).max()) if judged else 1,
        judged=(int(longest[0]) + histogram.first_code, int(longest[-1]) + histogram.first_code) if judged else None,
        missing=tuple(code + histogram.first_code for code in missing[:MOST_LISTED]),
        n_missing=len(missing),
    )


def _well_filled(counts: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell codes that are used from those where a few values strayed to, by the median of the codes around."""
    return counts >= EMPTY_SHARE * _local_median(counts)


def _local_median(counts: NDArray[np.float64]) -> NDArray[np.float64]:
    padded = np.pad(counts, WINDOW, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * WINDOW + 1), axis=1)


def _foretold(codes: NDArray[np.int64], counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how many values each distance between two filled codes forgoes per code, at least.

    Each side foretells the codes beyond it by its own decline from code to code; the smaller of the two is taken.
    Where both decline fast towards each other there is the valley between two peaks, of which nothing is foretold.
    """
    distances = np.diff(codes).astype(np.float64)
    ratios = np.minimum(counts[1:] / counts[:-1], 1.0), np.minimum(counts[:-1] / counts[1:], 1.0)
    ahead = np.append(1.0, ratios[0] ** (1.0 / distances))[:-1]
    behind = np.append(ratios[1] ** (1.0 / distances), 1.0)[1:]
    half = np.maximum(distances / 2.0, 1.0)
    valley = (ahead < 1.0) & (behind < 1.0) & (np.minimum(ahead, behind) < SLOW_DECLINE)
    return np.where(valley, 0.0, np.minimum(counts[:-1] * ahead**half, counts[1:] * behind**half))


def _runs(codes: NDArray[np.int64], counts: NDArray[np.float64], step: int) -> Iterator[NDArray[np.int64]]:
    """Yield filled codes in a row: whose neighbours are next to them, or should be."""
    if codes.size < 2:
        return
    distances = np.diff(codes)
    known = (distances == step) | (_foretold(codes, counts) >= FOREGONE)
    known &= np.minimum(counts[1:], counts[:-1]) >= FOREGONE
    breaks = np.flatnonzero(~known) + 1
    yield from np.split(codes, breaks)


def _missing(codes: NDArray[np.int64], counts: NDArray[np.float64], step: int) -> list[int]:
    if codes.size < 3:
        return []
    distances = np.diff(codes)
    gaps = (distances > step) & (distances <= WIDEST_GAP * step) & (_foretold(codes, counts) >= FOREGONE)
    return [
        code for index in np.flatnonzero(gaps) for code in range(int(codes[index]) + step, int(codes[index + 1]), step)
    ]


def _pattern(codes: NDArray[np.int64]) -> tuple[Pattern, float]:
    distances = np.diff(codes)
    if int(distances.max()) == 1:
        return Pattern.EVERY, 1.0
    told = int(distances.min()) > 1 or np.count_nonzero(distances > 1) >= FEWEST_GAPS
    slope = straight_slope(codes) if told else None
    if slope is not None:
        return Pattern.SCALED_UP, slope
    third = max(distances.size // 3, 1)
    low, high = float(distances[:third].mean()), float(distances[-third:].mean())
    if high > COMPANDED * low and int(distances.max()) > 1:
        return Pattern.COMPANDED, low
    return Pattern.MISSING, 1.0


def straight_slope(positions: Sequence[int] | NDArray[np.int64]) -> float | None:
    """Return a for which the positions are floor(a j + b), j = 0, 1, 2 ...; None where there is no such line.

    Examples
    --------
    >>> round(straight_slope(np.floor(1.37 * np.arange(200) + 0.2)), 3)
    1.37
    >>> straight_slope([0, 1, 2, 4, 6, 8]) is None
    True

    """
    points = np.asarray(positions, np.float64)
    index = np.arange(points.size)
    first = (points[-1] - points[0]) / (points.size - 1)
    low, high = first - 1.0 / (points.size - 1), first + 1.0 / (points.size - 1)

    def width(slope: float) -> float:
        return float(np.ptp(points - slope * index))

    golden = (math.sqrt(5.0) - 1.0) / 2.0
    for _ in range(60):
        left, right = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, right) if width(left) < width(right) else (left, high)
    slope = (low + high) / 2.0
    return float(slope) if width(slope) < 1.0 + 1e-9 else None


def _doubled(run: NDArray[np.int64], counts: NDArray[np.int64]) -> tuple[Pattern, float]:
    """Look for codes that are filled twice, or where most are, for those that are not, at regular distances."""
    filled = counts[run].astype(np.float64)
    usual = _local_median(filled)
    enough = np.concatenate(([False], usual >= ENOUGH_TO_DOUBLE, [False]))
    edges = np.flatnonzero(np.diff(enough.astype(np.int8))).reshape(-1, 2)
    if not edges.size:
        return Pattern.EVERY, 1.0
    first, last = edges[np.argmax(edges[:, 1] - edges[:, 0])]
    ratio = (filled / np.maximum(usual, 1.0))[first:last]
    doubled, single = (_period(places) for places in (ratio > DOUBLED, ratio < 1.0 / DOUBLED))
    if doubled is not None:
        return Pattern.SCALED_DOWN, doubled / (doubled + 1.0)
    if single is not None:
        return Pattern.SCALED_DOWN, 1.0 / (2.0 - 1.0 / single)
    return Pattern.EVERY, 1.0


def _period(places: NDArray[np.bool_]) -> float | None:
    """Return the regular distance of some codes, none of them next to another; None where they have none."""
    found = np.flatnonzero(places)
    period = straight_slope(found) if found.size >= FEWEST_DOUBLED else None
    return period if period is not None and period >= 2.0 else None
