"""What a mosaic itself tells of its colour filters: which of its four sites see the same light.

Small blocks of a scene are compared site by site. The two greens of a Bayer mosaic agree in every block up to texture;
red and blue do not. Which of them is red no mosaic can tell: it would take knowledge of the light.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

BLOCK: Final = 8
"""Edge of a block [cell]."""
FEWEST_BLOCKS: Final = 100
LIT_SHARE: Final = 0.05
"""Of the brightest blocks' signal, from where on a block is used; and the share of all blocks that must be."""
LIT_ERRORS: Final = 40.0
"""Standard errors of a block's mean that its signal must have: noise then differs by less than 4 %."""
ALIKE: Final = 0.15
"""Largest upper quartile of the relative difference of two sites that see the same light; texture makes it so large."""
APART: Final = 4.0
"""Times as much the other two sites must differ."""
SAME: Final = 0.03
"""The same of all sites where none has a filter of its own."""
CONTRAST: Final = 1.5
"""Ratio of bright and dark blocks' signals from where on a scene tells that all sites are alike."""
MAIN: Final = (0, 3)
ANTI: Final = (1, 2)


class Order(StrEnum):
    """What the sites of a mosaic come to; the greens of a Bayer mosaic lie on one diagonal."""

    GREENS_MAIN = "greens-main"
    GREENS_ANTI = "greens-anti"
    ALIKE = "alike"
    QUAD = "quad"
    UNTOLD = "untold"

    @property
    def names(self) -> tuple[str, ...]:
        """Return the CFA names that it allows."""
        return {"greens-main": ("GRBG", "GBRG"), "greens-anti": ("RGGB", "BGGR"), "alike": ("mono",)}.get(self, ())


@dataclass(frozen=True, slots=True, kw_only=True)
class MosaicOrder:
    """How the sites of a mosaic compare.

    Parameters
    ----------
    order
        What that comes to.
    main, anti
        Upper quartile over the blocks of the relative difference of the two sites on each diagonal [1].
    all_sites
        The largest of all six pairs [1].
    blocks
        How many were lit well enough.

    """

    order: Order
    main: float
    anti: float
    all_sites: float
    blocks: int


def mosaic_order(mosaic: NDArray[np.uint16], *, black_dn: float | None, white_dn: float | None = None) -> MosaicOrder:
    """Compare the four sites of a mosaic.

    Parameters
    ----------
    mosaic
        Shape (height, width) [DN].
    black_dn
        Its black level; None takes the darkest blocks for black [DN].
    white_dn
        The level where codes clip; None takes the highest code [DN].

    Examples
    --------
    >>> light = np.linspace(100.0, 900.0, 512)[:, np.newaxis] * np.linspace(0.5, 1.0, 512)
    >>> mosaic = (light * np.tile([[0.5, 1.0], [1.0, 0.3]], (256, 256))).astype(np.uint16)
    >>> mosaic_order(mosaic, black_dn=0.0).order.names
    ('RGGB', 'BGGR')

    """
    found = _compared(mosaic, black_dn=black_dn, white_dn=white_dn)
    if found.order is Order.UNTOLD:
        return found
    inside = [_compared(mosaic[r::2, c::2], black_dn=black_dn, white_dn=white_dn).order for r in (0, 1) for c in (0, 1)]
    quad = all(one in {Order.GREENS_ANTI, Order.GREENS_MAIN} for one in inside)
    if not quad:
        return found
    return MosaicOrder(
        order=Order.QUAD, main=found.main, anti=found.anti, all_sites=found.all_sites, blocks=found.blocks
    )


def _compared(mosaic: NDArray[np.uint16], *, black_dn: float | None, white_dn: float | None) -> MosaicOrder:
    height, width = (side // (2 * BLOCK) * BLOCK for side in mosaic.shape)
    untold = MosaicOrder(order=Order.UNTOLD, main=np.nan, anti=np.nan, all_sites=np.nan, blocks=0)
    if height * width < FEWEST_BLOCKS * BLOCK**2:
        return untold
    planes = [mosaic[r : 2 * height : 2, c : 2 * width : 2] for r in (0, 1) for c in (0, 1)]
    means = np.stack([_blocks(plane) for plane in planes])
    top = float(mosaic.max()) if white_dn is None else white_dn
    highest = np.stack([_tops(plane) for plane in planes]).max(axis=0)
    signals = means - (float(np.quantile(means, 0.001)) if black_dn is None else black_dn)
    level = signals.mean(axis=0)
    unclipped = highest < top
    if not unclipped.any():
        return untold
    errors = np.stack([_noise(plane) for plane in planes]).mean(axis=0) / BLOCK
    lit = unclipped & (level > LIT_SHARE * np.quantile(level[unclipped], 0.99)) & (level > LIT_ERRORS * errors)
    lit &= signals.min(axis=0) > 0.0
    blocks = int(lit.sum())
    if blocks < max(FEWEST_BLOCKS, LIT_SHARE * level.size):
        return untold
    differ = {
        (i, j): float(np.quantile(2.0 * np.abs(signals[i] - signals[j])[lit] / (signals[i] + signals[j])[lit], 0.75))
        for i, j in combinations(range(4), 2)
    }
    dark, bright = np.quantile(level[lit], (0.05, 0.95))
    return MosaicOrder(
        order=_decided(differ[MAIN], differ[ANTI], max(differ.values()), contrast=float(bright / dark)),
        main=differ[MAIN],
        anti=differ[ANTI],
        all_sites=max(differ.values()),
        blocks=blocks,
    )


def _decided(main: float, anti: float, every: float, *, contrast: float) -> Order:
    if every < SAME:
        return Order.ALIKE if contrast > CONTRAST else Order.UNTOLD
    if anti < ALIKE and main > max(ALIKE, APART * anti):
        return Order.GREENS_ANTI
    if main < ALIKE and anti > max(ALIKE, APART * main):
        return Order.GREENS_MAIN
    return Order.UNTOLD


def _blocks(plane: NDArray[np.uint16]) -> NDArray[np.float64]:
    rows, columns = plane.shape
    return plane.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).mean(axis=(1, 3), dtype=np.float64)


def _tops(plane: NDArray[np.uint16]) -> NDArray[np.uint16]:
    rows, columns = plane.shape
    return plane.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).max(axis=(1, 3))


def _noise(plane: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Return the noise of a pixel in every block, from differences along its rows; texture counts as noise [DN].

    Differences of next neighbours or of the next but one, the smaller: in a quad-Bayer mosaic these are of one colour.
    """
    values = plane.astype(np.int32)
    rows, columns = values.shape
    noises: list[NDArray[np.float64]] = []
    for lag in (1, 2):
        steps = values[:, lag:] - values[:, :-lag]
        squares = np.pad(np.square(steps.astype(np.float64)), ((0, 0), (0, lag)), mode="edge")
        blocks = squares.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK)
        noises.append(blocks.mean(axis=(1, 3)))
    return np.sqrt(np.minimum(*noises) / 2.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternation:
    """How far the even lines of a plane lie above the odd ones, and one standard error by the scatter of pairs [DN]."""

    difference_dn: float
    std_error_dn: float


def alternation(plane: NDArray[np.uint16], *, axis: int) -> Alternation:
    """Compare even and odd lines of one plane: two converters, or two amplifiers, that take turns.

    Parameters
    ----------
    plane
        Shape (rows, columns) [DN].
    axis
        0 for rows that take turns, 1 for columns.

    Examples
    --------
    >>> plane = np.random.default_rng(3).normal(500, 2, (100, 100)).astype(np.uint16)
    >>> plane[:, ::2] += 5
    >>> round(alternation(plane, axis=1).difference_dn), round(alternation(plane, axis=0).difference_dn)
    (5, 0)

    """
    lines = plane.mean(axis=1 - axis, dtype=np.float64)
    first, second = lines[0 : lines.size // 2 * 2 : 2], lines[1::2]
    # A slope over the lines cancels where each pair is taken against the mean of both its neighbours.
    middle = 0.5 * (second[:-1] + second[1:]) if first.size > 2 else second[:1]
    apart = first[1:] - middle if first.size > 2 else first[:1] - middle
    return Alternation(
        difference_dn=float(apart.mean()),
        std_error_dn=float(apart.std(ddof=1) / np.sqrt(max(apart.size / 1.5, 1.0))) if apart.size > 1 else np.inf,
    )
