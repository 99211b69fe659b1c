"""A scene divided by its shading: black first, then the map, codes stretched so that nothing is lost."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.frames.series import HIGHEST_CODE
from fullwell.raw.cfa import cell
from fullwell.raw.opcodes import GainMap, gain_map_places, mosaic_gain_maps
from fullwell.workflow.maps import GRID_COLUMNS, GRID_ROWS
from fullwell.workflow.shading.placement import Placement


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Corrected:
    """A scene without its shading, as codes.

    Parameters
    ----------
    mosaic
        uint16, shape (height, width): round(((code - black) / map + pedestal) * scale), where
        the pedestal is black, lifted where noise below black would otherwise fall below 0.
    black_level
        Per CFA site, row-major: pedestal times scale.
    white_level
        Codes at and above it are saturated wherever they lie: what white is at the centre of the map.
    scale
        Codes per DN of the scene: a whole number, so that no two codes of a pixel become one; below 1 only where the
        scene needs more than 16 bits.

    """

    mosaic: NDArray[np.uint16]
    black_level: tuple[float, ...]
    white_level: int
    scale: float


def corrected(
    mosaic: NDArray[np.uint16], placement: Placement, *, black_level: Sequence[float], white_level: Sequence[float]
) -> Corrected:
    """Return a scene divided by its map.

    Parameters
    ----------
    mosaic
        Codes of the visible mosaic, shape (height, width) [DN].
    placement
        The map laid on the scene.
    black_level, white_level
        Per CFA site, row-major [DN].

    Raises
    ------
    UsageError
        Where the map is not above 0 everywhere, so that nothing can be divided by it, or the scene lies below the black
        level, which is then not its own.

    """
    highest = float(np.percentile(mosaic, 99.0))
    if highest < min(black_level):
        raise UsageError(
            f"the black level {min(black_level):g} DN lies above the scene, whose codes go up to {highest:g} DN: it is "
            "not this scene's; give its own with --black"
        )
    period = cell(placement.scene.cfa)
    planes = [
        _divided(mosaic, placement, site, black_dn=black, white_dn=white)
        for site, (black, white) in enumerate(zip(black_level, white_level, strict=True))
    ]
    lift = max(0.0, *(math.ceil(-plane.lowest_dn - black) for plane, black in zip(planes, black_level, strict=True)))
    pedestals = [black + lift for black in black_level]
    needed = max(plane.highest_dn + pedestal for plane, pedestal in zip(planes, pedestals, strict=True))
    whole = math.floor(HIGHEST_CODE / needed)
    scale = float(whole) if whole >= 1 else HIGHEST_CODE / needed
    out = np.empty(mosaic.shape, dtype=np.uint16)
    for site, (plane, pedestal) in enumerate(zip(planes, pedestals, strict=True)):
        codes = np.rint((plane.values_dn + pedestal) * scale)
        out[site // period :: period, site % period :: period] = codes.astype(np.uint16)
    return Corrected(
        mosaic=out,
        black_level=tuple(pedestal * scale for pedestal in pedestals),
        white_level=math.floor((min(white_level) + lift) * scale),
        scale=scale,
    )


def gain_maps(placement: Placement) -> tuple[GainMap, ...]:
    """Return the reciprocal of a map as DNG gain maps, one per CFA site of the scene; readers clip at white."""
    scene = placement.scene
    down, across = min(GRID_ROWS, scene.height), min(GRID_COLUMNS, scene.width)
    rows, columns = gain_map_places(down, scene.height), gain_map_places(across, scene.width)
    factors = [_above_zero(placement.at(site, rows, columns)) for site in range(cell(scene.cfa) ** 2)]
    values = np.stack([1.0 / one for one in factors])
    return mosaic_gain_maps(values, cfa=scene.cfa, size=(scene.height, scene.width))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Divided:
    """One plane divided by its map: values, and what its lowest and highest possible value is [DN]."""

    values_dn: NDArray[np.float64]
    lowest_dn: float
    highest_dn: float


def _divided(
    mosaic: NDArray[np.uint16], placement: Placement, site: int, *, black_dn: float, white_dn: float
) -> _Divided:
    period = cell(placement.scene.cfa)
    top, left = site // period, site % period
    plane = mosaic[top::period, left::period]
    rows = np.arange(top, mosaic.shape[0], period, dtype=np.float64)
    columns = np.arange(left, mosaic.shape[1], period, dtype=np.float64)
    values = _above_zero(placement.at(site, rows, columns))
    least = float(values.min())
    np.divide(plane - black_dn, values, out=values)
    return _Divided(
        values_dn=values,
        lowest_dn=float(values.min()),
        highest_dn=max((white_dn - black_dn) / least, float(values.max())),
    )


def _above_zero(values: NDArray[np.float64]) -> NDArray[np.float64]:
    if not values.min() > 0.0:
        raise UsageError("the shading map is not above 0 everywhere; fit it again to flats that are lit to the corners")
    return np.ascontiguousarray(values)
