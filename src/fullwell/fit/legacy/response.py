"""The Pixel study's own arithmetic for PRNU and DSNU, to the last digit (METHOD 5.3).

Everything follows from burst sums. The traps are the study's and stay in: pedestal left in, all bursts divided by one
map, green as the mean of both greens, temporal noise counted as pattern. The corrected figures are measured elsewhere.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.legacy.regions import Box, StudyRegions
from fullwell.fit.legacy.shading_map import LegacyMap
from fullwell.raw.cfa import ALL, MONO, channels
from fullwell.statistics.pixels import PixelSums, line_coefficients
from fullwell.units import DN, PERCENT

_ROWS: Final = 32
"""Of the crop, worked on at once: they stay in the cache."""
_Number = TypeVar("_Number", bound=np.generic)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelResponse:
    """Line of signal against exposure, pixel by pixel.

    Parameters
    ----------
    channel
        ``all`` (every pixel, the colours mixed as published), ``R``, ``G`` (mean of both greens), ``B``; or ``mono``.
    slope_dn_per_s, intercept_dn
        Shape (V, H) [DN/s], [DN].

    """

    channel: str
    slope_dn_per_s: NDArray[np.float64]
    intercept_dn: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations (divisor n - 1) and means of response maps, shape (regions, channels).

    Parameters
    ----------
    slope_std, slope_mean
        [DN/s].
    intercept_std, intercept_mean
        [DN].

    """

    slope_std: NDArray[np.float64]
    slope_mean: NDArray[np.float64]
    intercept_std: NDArray[np.float64]
    intercept_mean: NDArray[np.float64]

    @property
    def prnu_percent(self) -> NDArray[np.float64]:
        """Return what the study calls PRNU, shape (regions, channels) [%]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return 100.0 * (self.slope_std / self.slope_mean)


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResponse:
    """All that the study derives from the flats of one ISO.

    Parameters
    ----------
    iso
        None where nothing says it.
    regions
        Crop and tiles.
    crop
        Response of the crop, one per channel: all, R, G, B; or mono alone.
    tiles
        The same of each of the 16 tiles.
    crop_spread, tile_spread
        One row, and one row per tile.

    """

    iso: float | None
    regions: StudyRegions
    crop: tuple[ChannelResponse, ...]
    tiles: tuple[tuple[ChannelResponse, ...], ...]
    crop_spread: Spread
    tile_spread: Spread

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the names of the channels, in the order of the tables' columns."""
        return tuple(one.channel for one in self.crop)


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyFigure:
    """A published figure of merit, without an uncertainty since its authors gave none.

    Parameters
    ----------
    quantity, channel, method, value, unit
        As in a row of results.
    region
        ``x,y,width,height`` of the crop; None for the median over the 16 tiles.
    n
        Pixels used.
    flags
        ``scaled-crop``, or empty.

    """

    quantity: str
    channel: str
    method: str
    value: float
    unit: str
    region: str | None
    n: int
    flags: tuple[str, ...] = ()


def study_response(
    sums: Sequence[PixelSums],
    frames: Sequence[int],
    exposures_s: Sequence[float],
    *,
    iso: float | None,
    cfa: str,
    base: LegacyMap,
    regions: StudyRegions,
    black_dn: Sequence[float] | None = None,
) -> StudyResponse:
    """Fit the line of every pixel of the crop, as the study's evaluate_prnu_dsnu does.

    Parameters
    ----------
    sums
        Sum over the frames of each pixel, one mosaic per exposure, shape (height, width) [DN].
    frames
        Frames in each sum.
    exposures_s
        At least two different ones [s].
    iso, cfa
        Of the flats.
    base
        The one map by which the study divides the flats of every ISO.
    regions
        From `study_regions`.
    black_dn
        As in `fit_legacy_map`: None leaves the pedestal in, as published [DN].

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    weights = line_coefficients(exposures_s)
    crop = regions.crop
    maps = np.zeros((2, crop.height, crop.width))
    for top in range(0, crop.height, _ROWS):
        rows = slice(top, top + _ROWS)
        for burst, count, weight in zip(sums, frames, weights.T, strict=True):
            mean = _cut(burst, crop)[rows] / count
            maps[:, rows] += weight[:, None, None] * mean
    if black_dn is not None:
        period = base.cell
        for site, black in enumerate(black_dn):
            maps[1, (site // period - crop.top) % period :: period, (site % period - crop.left) % period :: period] -= (
                black
            )
    maps /= base.region(top=crop.top, left=crop.left, height=crop.height, width=crop.width)
    whole = _by_channel(maps, cfa)
    tiles = tuple(_by_channel(_cut(maps, _within(tile, crop)), cfa) for tile in regions.tiles)
    return StudyResponse(
        iso=iso,
        regions=regions,
        crop=whole,
        tiles=tiles,
        crop_spread=_spread([whole]),
        tile_spread=_spread(tiles),
    )


def response_figures(response: StudyResponse) -> tuple[LegacyFigure, ...]:
    """Return the study's PRNU and DSNU per channel: of the crop, and the median over the 16 tiles (METHOD 5.3)."""
    crop, regions = response.regions.crop, response.regions
    place = f"{crop.left},{crop.top},{crop.width},{crop.height}"
    flags = ("scaled-crop",) if regions.scaled else ()
    figures: list[LegacyFigure] = []
    for index, whole in enumerate(response.crop):
        in_tiles = sum(one[index].slope_dn_per_s.size for one in response.tiles)
        parts = (
            (place, whole.slope_dn_per_s.size, response.crop_spread),
            (None, in_tiles, response.tile_spread),
        )
        for region, n, spread in parts:
            prnu = float(np.median(spread.prnu_percent[:, index]))
            dsnu = float(np.median(spread.intercept_std[:, index]))
            for quantity, method, value, unit in (
                ("prnu", "legacy-slope-std", prnu, PERCENT),
                ("dsnu", "legacy-intercept-std", dsnu, DN),
            ):
                figures.append(
                    LegacyFigure(
                        quantity=quantity,
                        channel=whole.channel,
                        method=method,
                        value=value,
                        unit=unit,
                        region=region,
                        n=n,
                        flags=flags,
                    )
                )
    return tuple(figures)


def _within(tile: Box, crop: Box) -> Box:
    return Box(top=tile.top - crop.top, left=tile.left - crop.left, height=tile.height, width=tile.width)


def _cut(values: NDArray[_Number], box: Box) -> NDArray[_Number]:
    return values[..., box.top : box.top + box.height, box.left : box.left + box.width]


def _by_channel(maps: NDArray[np.float64], cfa: str) -> tuple[ChannelResponse, ...]:
    """Split slope and intercept, shape (2, V, H), as the study's split_channels."""
    return tuple(
        ChannelResponse(channel=channel, slope_dn_per_s=part[0], intercept_dn=part[1])
        for channel, part in _split(maps, cfa)
    )


def _split(maps: NDArray[np.float64], cfa: str) -> Iterator[tuple[str, NDArray[np.float64]]]:
    if cfa == MONO:
        yield MONO, maps
        return
    planes = {name: maps[..., site // 2 :: 2, site % 2 :: 2] for site, name in enumerate(channels(cfa))}
    yield ALL, maps
    yield "R", planes["R"]
    yield "G", (planes["G1"] + planes["G2"]) / 2.0
    yield "B", planes["B"]


def _spread(regions: Sequence[Sequence[ChannelResponse]]) -> Spread:
    def each(measure: Callable[[NDArray[np.float64]], float], name: str) -> NDArray[np.float64]:
        return np.array([[measure(getattr(one, name)) for one in region] for region in regions])

    return Spread(
        slope_std=each(_std2, "slope_dn_per_s"),
        slope_mean=each(_mean2, "slope_dn_per_s"),
        intercept_std=each(_std2, "intercept_dn"),
        intercept_mean=each(_mean2, "intercept_dn"),
    )


def _std2(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else 0.0


def _mean2(values: NDArray[np.float64]) -> float:
    return float(values.mean())
