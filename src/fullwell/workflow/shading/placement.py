"""How a shading map lies on a scene: turned by quarters, or with the colours of its mosaic shifted.

A tag Orientation only tells how a picture is to be shown, and most raw files keep the sensor's own order whatever it
says. Some programs turn the mosaic itself: then its size or its CFA shows it, and where both leave it open, the tags.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.raw.cfa import MONO, cell, shifted
from fullwell.workflow.maps import ChannelMap, ShadingMapFile

FloatArray = NDArray[np.float64]

_SHOWN_LEFT: Final = {1: 0, 3: 2, 6: 3, 8: 1}
"""Quarter turns to the left that show a picture upright, by the tag Orientation; mirrored ones are left aside."""
_STEPS: Final = ((0, 0), (0, 1), (1, 0), (1, 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """Size, colours and orientation of a mosaic.

    Parameters
    ----------
    height, width
        Of the visible mosaic [pixel].
    cfa
        Order at its top-left pixel, or ``mono``.
    orientation
        TIFF tag Orientation.

    """

    height: int
    width: int
    cfa: str
    orientation: int = 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placement:
    """A map laid on a scene.

    Parameters
    ----------
    shading
        The map.
    scene
        What it is laid on.
    quarters
        Quarter turns to the left that take the map's mosaic to the scene's.
    shift
        Rows and columns by which the colours of the turned map are shifted against the scene's.

    """

    shading: ShadingMapFile
    scene: Geometry
    quarters: int
    shift: tuple[int, int]

    def channel(self, site: int) -> ChannelMap:
        """Return the plane of the map that belongs to a CFA site of the scene."""
        return self.shading.channels[self._map_site(site)]

    def at(self, site: int, rows: FloatArray, columns: FloatArray) -> FloatArray:
        """Return the map of one CFA site at the outer product of scene rows (R,) and columns (C,), shape (R, C) [1].

        Parameters
        ----------
        site
            CFA site of the scene, row-major.
        rows, columns
            In pixels of the scene's visible mosaic, counted from 0, fractions allowed.

        """
        period = cell(self.shading.cfa)
        own = self._map_site(site)
        map_rows, map_columns = self._in_map(rows, columns)
        values = self.shading.channels[own].at(
            (map_rows - own // period) / period, (map_columns - own % period) / period
        )
        return values.T if self.quarters % 2 else values

    def _map_site(self, site: int) -> int:
        if self.scene.cfa == MONO:
            return 0
        row, column = (site // 2 + self.shift[0]) % 2, (site + self.shift[1]) % 2
        down, across = self._in_map(np.array([float(row)]), np.array([float(column)]))
        return int(down[0]) % 2 * 2 + int(across[0]) % 2

    def _in_map(self, rows: FloatArray, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return rows and columns of the map's mosaic that lie on those of the scene."""
        last_row, last_column = self.shading.height - 1.0, self.shading.width - 1.0
        if self.quarters == 0:
            return rows, columns
        if self.quarters == 1:
            return columns, last_column - rows
        if self.quarters == 2:
            return last_row - rows, last_column - columns
        return last_row - columns, rows


def place(shading: ShadingMapFile, scene: Geometry, *, quarters: int | None = None) -> Placement:
    """Decide how a map lies on a scene.

    Parameters
    ----------
    shading
        The map.
    scene
        What it is to be laid on.
    quarters
        Quarter turns to the left, where the user says so; None decides from size, CFA and orientation.

    Raises
    ------
    UsageError
        Where the map does not fit: the sentence says what to do.

    """
    mono = [one == MONO for one in (shading.cfa, scene.cfa)]
    if any(mono) and not all(mono):
        raise UsageError(
            f"the scene's CFA is {scene.cfa}, the map's is {shading.cfa}; one of them is wrong, or another camera took "
            "the flats. Give --cfa where the scene says nothing."
        )
    chosen = _quarters(shading, scene) if quarters is None else quarters
    size = (shading.height, shading.width)
    if (size[::-1] if chosen % 2 else size) != (scene.height, scene.width):
        raise UsageError(_wrong_size(shading, scene, chosen))
    turned = turned_cfa(shading.cfa, quarters=chosen, size=size)
    shift = next(step for step in _STEPS if shifted(turned, rows=step[0], columns=step[1]) == scene.cfa)
    return Placement(shading=shading, scene=scene, quarters=chosen, shift=shift)


def turned_cfa(cfa: str, *, quarters: int, size: tuple[int, int]) -> str:
    """Return the order at the top-left pixel of a mosaic that was turned to the left.

    Parameters
    ----------
    cfa
        Before.
    quarters
        Quarter turns to the left.
    size
        Height and width before [pixel].

    Examples
    --------
    >>> [turned_cfa("RGGB", quarters=quarters, size=(4, 6)) for quarters in range(4)]
    ['RGGB', 'GBRG', 'BGGR', 'GRBG']

    """
    if cfa == MONO:
        return cfa
    few = (2 + size[0] % 2, 2 + size[1] % 2)
    letters = np.array([[cfa[row % 2 * 2 + column % 2] for column in range(few[1])] for row in range(few[0])])
    return "".join(np.rot90(letters, quarters)[:2, :2].ravel().tolist())


def _quarters(shading: ShadingMapFile, scene: Geometry) -> int:
    """Return the quarter turns to the left from the map's mosaic to the scene's."""
    size = (shading.height, shading.width)
    same, transposed = (size == (scene.height, scene.width), size[::-1] == (scene.height, scene.width))
    fits = [turned_cfa(shading.cfa, quarters=quarters, size=size) == scene.cfa for quarters in range(4)]
    tags = _quarters_by_tags(shading.orientation, scene.orientation)
    if same and fits[0]:
        return 0
    if same and tags is not None and fits[tags] and (tags == 2 or transposed):
        return tags
    if same or not transposed:
        return 0
    sideways = [quarters for quarters in (1, 3) if fits[quarters]]
    if len(sideways) == 1:
        return sideways[0]
    if tags in {1, 3}:
        return tags
    raise UsageError(
        f"the scene is {scene.width} x {scene.height} pixels and the map {shading.width} x {shading.height}: it is "
        "turned, but neither its CFA nor its orientation tag says which way. Give --turn 90 or --turn 270."
    )


def _quarters_by_tags(former: int, scene: int) -> int | None:
    """Return the turn between two mosaics that look alike when shown upright; None where a tag mirrors."""
    if former not in _SHOWN_LEFT or scene not in _SHOWN_LEFT:
        return None
    return (_SHOWN_LEFT[former] - _SHOWN_LEFT[scene]) % 4


def _wrong_size(shading: ShadingMapFile, scene: Geometry, quarters: int) -> str:
    turned = f" turned by {90 * (-quarters % 4)} degrees to the right" if quarters else ""
    return (
        f"the scene is {scene.width} x {scene.height} pixels, the map {shading.width} x {shading.height}{turned}: a "
        "map holds for frames of its own size. Take flats in the scene's mode, without --crop, and fit the map to them."
    )
