"""Masked pixels: what lies beside the visible mosaic and never saw light (METHOD 2.3 (iii))."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell
from fullwell.raw.image import Area, RawHeader
from fullwell.raw.open import decode

_EDGE: Final = 8
"""Pixels left out at the edges of a margin: light and charge reach over them."""
_DECLARED_EDGE: Final = 2
"""The same of an area that the file names as masked."""
_NARROWEST: Final = 8
"""Width of what is left, from where on an area is used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskedSums:
    """One CFA site of one area of one frame.

    Parameters
    ----------
    mean_dn, variance_dn2, n
        Over its pixels [DN, DN^2].
    line_error_dn
        Standard error of the mean by the scatter of the means of its rows or columns, the larger [DN].
    declared
        As in `MaskedArea`.

    """

    site: int
    mean_dn: float
    variance_dn2: float
    n: int
    line_error_dn: float
    declared: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskedArea:
    """The masked pixels of one CFA site: all frames' together.

    Parameters
    ----------
    mean_dn, std_error_dn
        Mean; its error from the scatter of the means of lines, which row and column noise widen [DN].
    variance_dn2, dof
        Of a pixel about the mean of its area [DN^2].
    declared
        Whether the file names the area as masked; else it is a margin beside the visible mosaic.

    """

    channel: str
    mean_dn: float
    std_error_dn: float
    variance_dn2: float
    dof: float
    n: int
    declared: bool


def masked_sums(header: RawHeader, data: bytes | memoryview) -> tuple[MaskedSums, ...]:
    """Return what the masked pixels of a file that is in memory come to, per area and CFA site.

    Areas are those that the file declares; without any, the margins beside the visible mosaic, which are at least 16
    pixels wider than what is used of them.
    """
    found: list[MaskedSums] = []
    for area, declared in _areas(header):
        mosaic = decode(replace(header, active_area=area), data)
        step = cell(header.cfa or "mono")
        for site in range(step * step):
            row = (site // step + header.active_area.top - area.top) % step
            column = (site % step + header.active_area.left - area.left) % step
            found.append(_sums(mosaic[row::step, column::step], site, declared=declared))
    return tuple(one for one in found if one.n > 0)


def has_masked(header: RawHeader) -> bool:
    """Tell whether a file has masked pixels, declared or beside the visible mosaic."""
    return bool(_areas(header))


def masked_area(frames: Sequence[Sequence[MaskedSums]], channels: Sequence[str]) -> tuple[MaskedArea, ...]:
    """Pool areas and frames per channel; empty where there are none.

    Lines of one area keep their pattern from frame to frame, so frames do not lower the error that lines give.
    """
    pooled: list[MaskedArea] = []
    for site, channel in enumerate(channels):
        parts = [one for frame in frames for one in frame if one.site == site]
        if not parts:
            continue
        weights = np.array([one.n for one in parts], np.float64)
        means = np.array([one.mean_dn for one in parts])
        mean = float(weights @ means / weights.sum())
        areas = max(len(parts) // len(frames), 1)
        lines = math.sqrt(float(np.mean([one.line_error_dn**2 for one in parts])) / areas)
        between = float(np.sqrt(np.average((means - mean) ** 2, weights=weights) / max(areas - 1, 1)))
        variance = float(weights @ np.array([one.variance_dn2 for one in parts]) / weights.sum())
        pooled.append(
            MaskedArea(
                channel=channel,
                mean_dn=mean,
                std_error_dn=max(lines, between if areas > 1 else 0.0, math.sqrt(variance / weights.sum())),
                variance_dn2=variance,
                dof=float(weights.sum()) - len(parts),
                n=int(weights.sum()),
                declared=parts[0].declared,
            )
        )
    return tuple(pooled)


def _areas(header: RawHeader) -> tuple[tuple[Area, bool], ...]:
    if header.masked_areas:
        areas = [(_within(area, _DECLARED_EDGE), True) for area in header.masked_areas]
    else:
        active = header.active_area
        margins = (
            Area(0, 0, active.top, header.raw_width),
            Area(active.bottom, 0, header.raw_height, header.raw_width),
            Area(active.top, 0, active.bottom, active.left),
            Area(active.top, active.right, active.bottom, header.raw_width),
        )
        areas = [(_within(area, _EDGE), False) for area in margins]
    return tuple(
        (area, declared)
        for area, declared in areas
        if min(area.bottom - area.top, area.right - area.left) >= _NARROWEST
    )


def _within(area: Area, edge: int) -> Area:
    return Area(area.top + edge, area.left + edge, area.bottom - edge, area.right - edge)


def _sums(plane: NDArray[np.uint16], site: int, *, declared: bool) -> MaskedSums:
    values = plane.astype(np.float64)
    rows, columns = values.shape
    if min(rows, columns) < 2:
        return MaskedSums(site=site, mean_dn=0.0, variance_dn2=0.0, n=0, line_error_dn=0.0, declared=declared)
    row_error = float(values.mean(axis=1).std(ddof=1)) / math.sqrt(rows)
    column_error = float(values.mean(axis=0).std(ddof=1)) / math.sqrt(columns)
    return MaskedSums(
        site=site,
        mean_dn=float(values.mean()),
        variance_dn2=float(values.var(ddof=1)),
        n=values.size,
        line_error_dn=max(row_error, column_error),
        declared=declared,
    )
