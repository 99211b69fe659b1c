"""What the pixels of one file tell of it: codes, rails, colour filters, optical black, defects."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.findings import Finding
from fullwell.raw.cfa import MONO, cell, channels
from fullwell.raw.image import RawHeader
from fullwell.raw.segments import Layout
from fullwell.statistics.codes import CodeUse, code_use
from fullwell.statistics.isolated_pixels import IsolatedPixels, isolated_pixels
from fullwell.statistics.mosaic_order import MosaicOrder, Order, mosaic_order
from fullwell.statistics.series import Histogram
from fullwell.workflow.masked import MaskedArea, masked_area, masked_sums
from fullwell.workflow.measure.code_gaps import code_findings, effective_bits
from fullwell.workflow.measure.white_level import WhiteLevel, pile_up, white_findings
from fullwell.workflow.signs.order import alternation_findings, order_findings
from fullwell.workflow.signs.pixels import isolated_findings
from fullwell.workflow.signs.rails import (
    clipping_findings,
    darker_findings,
    noise_findings,
    optical_black_findings,
    range_findings,
)

SITES: Final = ("top left", "top right", "bottom left", "bottom right")
"""What the sites of a mosaic are called whose order nobody says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Content:
    """What the pixels of one file tell.

    Parameters
    ----------
    effective_bits
        Bit depth less what the code step leaves unused; None where all codes are zero [bit].
    channels
        By CFA site.
    histograms, uses, whites
        Codes of every channel without pixels that stand alone; how they are used; where they end.
    order
        What the content tells of the colour filters.
    masked
        Optical black of every channel; empty where the file has no masked pixels.
    isolated
        Pixels that stand alone.
    findings
        What is to be said of all that.

    """

    effective_bits: int | None
    channels: tuple[str, ...]
    histograms: tuple[Histogram, ...]
    uses: tuple[CodeUse, ...]
    whites: tuple[WhiteLevel, ...]
    order: MosaicOrder
    masked: tuple[MaskedArea, ...]
    isolated: IsolatedPixels
    findings: tuple[Finding, ...]


def look_at(header: RawHeader, data: bytes, mosaic: NDArray[np.uint16]) -> Content:
    """Look at the pixels of a file.

    Parameters
    ----------
    header
        What the file says.
    data
        All its bytes, for the margins beside the visible mosaic.
    mosaic
        The visible mosaic [DN].

    """
    white = None if header.white_level is None else min(header.white_level.values)
    order = mosaic_order(mosaic, black_dn=_declared_black(header), white_dn=white)
    names = _names(header.cfa, order.order)
    step = 1 if len(names) == 1 else 2
    planes = [mosaic[site // step :: step, site % step :: step] for site in range(step * step)]
    isolated = isolated_pixels(mosaic, cell=step)
    whole = [_histogram(plane) for plane in planes]
    histograms = tuple(_without(one, site, step, isolated, mosaic) for site, one in enumerate(whole))
    uses = tuple(code_use(histogram) for histogram in histograms)
    whites = tuple(
        _white(header, name, site, one) for site, (name, one) in enumerate(zip(names, histograms, strict=True))
    )
    masked = masked_area([masked_sums(header, data)], names) if _declares(header.cfa, step) else ()
    together = int(np.bitwise_or.reduce(mosaic, axis=None))
    findings = (
        *range_findings(names, whole, bit_depth=_decoded_bits(header)),
        *clipping_findings(names, histograms),
        *white_findings(whites),
        *optical_black_findings(masked, header.black_level),
        *darker_findings(names, planes, header.black_level),
        *noise_findings(masked, planes[: len(masked)]),
        *code_findings(names, uses),
        *order_findings(order, cfa=header.cfa),
        *alternation_findings(planes, names),
        *isolated_findings(isolated, mosaic),
    )
    return Content(
        effective_bits=effective_bits(
            uses,
            bit_depth=header.bit_depth,
            code_bits=_code_bits(header, histograms),
            unused_bits=_unused_bits(together),
        ),
        channels=names,
        histograms=histograms,
        uses=uses,
        whites=whites,
        order=order,
        masked=masked,
        isolated=isolated,
        findings=findings,
    )


def _declared_black(header: RawHeader) -> float | None:
    """Return the lowest declared black level; None where the file does not say, or says 0 [DN]."""
    black = header.black_level
    return min(black.values) if black is not None and black.source != "default" and min(black.values) > 0.0 else None


def _decoded_bits(header: RawHeader) -> int:
    """Return the bits that codes may have once they are decoded, where a LinearizationTable may widen them [bit]."""
    layout = header.layout
    table = layout.table if isinstance(layout, Layout) else ()
    return max(header.bit_depth, max(table, default=0).bit_length())


def _code_bits(header: RawHeader, histograms: Sequence[Histogram]) -> int:
    """Return the bits that the declared white level takes; all of them where codes lie above it [bit]."""
    bits = _decoded_bits(header)
    white = 2**bits - 1 if header.white_level is None else int(max(header.white_level.values))
    highest = max(one.first_code + len(one.counts) - 1 for one in histograms)
    return bits if highest > white else min(bits, white.bit_length())


def _names(cfa: str | None, order: Order) -> tuple[str, ...]:
    if cfa is not None:
        return channels(cfa)
    return SITES if order in {Order.GREENS_ANTI, Order.GREENS_MAIN, Order.QUAD} else channels(MONO)


def _declares(cfa: str | None, step: int) -> bool:
    return cell(cfa or MONO) == step


def _histogram(plane: NDArray[np.uint16]) -> Histogram:
    counts = np.bincount(np.ascontiguousarray(plane).ravel()).astype(np.int64)
    first = int(np.flatnonzero(counts)[0])
    return Histogram(first_code=first, counts=counts[first:], frames=1)


def _without(whole: Histogram, site: int, step: int, isolated: IsolatedPixels, mosaic: NDArray[np.uint16]) -> Histogram:
    """Return the histogram of a site without the pixels that stand alone."""
    counts = whole.counts.copy()
    for places in (isolated.above, isolated.below):
        rows, columns = places[:, 0], places[:, 1]
        own = (rows % step * step + columns % step) == site
        np.subtract.at(counts, mosaic[rows[own], columns[own]].astype(np.int64) - whole.first_code, 1)
    present = np.flatnonzero(counts)
    first, last = int(present[0]), int(present[-1])
    return Histogram(first_code=whole.first_code + first, counts=counts[first : last + 1], frames=1)


def _white(header: RawHeader, channel: str, site: int, histogram: Histogram) -> WhiteLevel:
    declared: Sequence[float] | None = None if header.white_level is None else header.white_level.values
    return WhiteLevel(
        channel=channel,
        declared=None if declared is None else declared[site if len(declared) > 1 else 0],
        seen=histogram.first_code + len(histogram.counts) - 1,
        piles_up=pile_up(histogram),
        n=int(histogram.counts.sum()),
    )


def _unused_bits(together: int) -> int | None:
    return (together & -together).bit_length() - 1 if together else None
