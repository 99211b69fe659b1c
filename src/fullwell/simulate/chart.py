"""The chart in front of the camera: where its patches are in the frame, and how light each is.

Patches are rectangles of even pixels. What is written into PATCHES.csv is their middles, so that nothing of an edge is
measured even where the lens is out of focus.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError, why
from fullwell.frames.chart.definition import ChartDefinition, chart_named
from fullwell.frames.chart.patches import COLUMNS, SMALLEST, Patch, inset
from fullwell.simulate.tables import CameraTable, ChartTable

_EDGE: Final = 0.1
"""Share of a patch left out on each side, where the chart's geometry is made here."""

FloatArray = NDArray[np.float64]
Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Painting:
    """A chart as the camera sees it.

    Parameters
    ----------
    whole
        Every patch from edge to edge.
    measured
        What PATCHES.csv says of them.
    light
        Red, green and blue of each patch, relative to a perfect white [1].
    surround
        Light of everything around them [1].

    """

    whole: tuple[Patch, ...]
    measured: tuple[Patch, ...]
    light: tuple[Colour, ...]
    surround: float

    @property
    def lightest(self) -> float:
        """Return the light of the lightest patch of known density, which flare is a share of; 1 where none is [1]."""
        known = [patch.density for patch in self.measured if patch.density is not None]
        return 10.0 ** -min(known) if known else 1.0

    def seen(self, rows: FloatArray, columns: FloatArray, colour: int) -> FloatArray:
        """Return the light at the outer product of rows and columns [1].

        Parameters
        ----------
        rows, columns
            Places in pixels of the visible mosaic, ascending; a pixel's middle lies at a half.
        colour
            0, 1, 2 for red, green, blue.

        """
        out = np.full((rows.size, columns.size), self.surround)
        for patch, light in zip(self.whole, self.light, strict=True):
            top, bottom = np.searchsorted(rows, (patch.y, patch.y + patch.height))
            left, right = np.searchsorted(columns, (patch.x, patch.x + patch.width))
            out[top:bottom, left:right] = light[colour]
        return out

    def write(self, path: Path) -> None:
        """Write PATCHES.csv (RESULTS 3); the column of densities is left out where one is unknown."""
        known = all(patch.density is not None for patch in self.measured)
        names = COLUMNS if known else COLUMNS[:-1]
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names)
            for patch in self.measured:
                place = (patch.name, patch.x, patch.y, patch.width, patch.height)
                writer.writerow((*place, f"{patch.density:.10g}") if known else place)


def painted(table: ChartTable, camera: CameraTable, *, folder: Path) -> Painting:
    """Return the chart that a config describes, in the frame of its camera.

    Raises
    ------
    UsageError
        Where a file cannot be read, or patches do not fit the frame.

    """
    if table.patches:
        return _given(table, camera)
    if table.name is not None:
        return _named(table, camera, folder=folder)
    return _grid(table, camera, _densities(table, folder=folder))


def _given(table: ChartTable, camera: CameraTable) -> Painting:
    patches = tuple(
        Patch(name=one.name, x=one.x, y=one.y, width=one.width, height=one.height, density=one.density)
        for one in table.patches
    )
    for one in patches:
        if one.x + one.width > camera.width or one.y + one.height > camera.height:
            raise UsageError(
                f"chart.patches: patch {one.name} ({one.x},{one.y},{one.width},{one.height}) reaches out of the frame; "
                f"allowed: up to {camera.width} x {camera.height} pixels."
            )
    return _painting(table, whole=patches, measured=patches, light=tuple(_grey(one.density) for one in patches))


def _named(table: ChartTable, camera: CameraTable, *, folder: Path) -> Painting:
    name = str(table.name)
    chart = chart_named(str(folder / name) if name.endswith(".toml") else name)
    known = [one.density for one in chart.patches]
    if table.densities is not None:
        known = list(_densities(table, folder=folder))
        if len(known) != len(chart.patches):
            raise UsageError(f"chart.densities has {len(known)} numbers; {name} has {len(chart.patches)} patches.")
    whole = tuple(
        Patch(name=one.name, x=x, y=y, width=width, height=height, density=density)
        for one, density, (x, y, width, height) in zip(chart.patches, known, _places(chart, table, camera), strict=True)
    )
    light = tuple(
        one.rgb if chart.coloured or density is None else _grey(density)
        for one, density in zip(chart.patches, known, strict=True)
    )
    return _painting(table, whole=whole, measured=_middles(whole, table), light=light)


def _places(chart: ChartDefinition, table: ChartTable, camera: CameraTable) -> list[tuple[int, int, int, int]]:
    """Return x, y, width and height of every patch, the chart as large as the margin lets it be [pixel]."""
    room = 1.0 - 2.0 * table.margin
    width = min(room * camera.width, room * camera.height * chart.aspect)
    height = width / chart.aspect
    left, top = (camera.width - width) / 2.0, (camera.height - height) / 2.0
    return [
        (
            _even(left + (one.x - one.width / 2.0) * width),
            _even(top + (one.y - one.height / 2.0) * height),
            _even(one.width * width),
            _even(one.height * height),
        )
        for one in chart.patches
    ]


def _grid(table: ChartTable, camera: CameraTable, densities: tuple[float, ...]) -> Painting:
    """Return squares row by row, the first at the top left."""
    columns = table.columns or math.ceil(math.sqrt(len(densities) * camera.width / camera.height))
    rows = math.ceil(len(densities) / columns)
    room = 1.0 - 2.0 * table.margin
    pitch = min(room * camera.width / columns, room * camera.height / rows)
    size = _even(table.fill * pitch)
    left, top = (camera.width - columns * pitch) / 2.0, (camera.height - rows * pitch) / 2.0
    whole = tuple(
        Patch(
            name=str(number + 1),
            x=_even(left + (number % columns + 0.5) * pitch - size / 2.0),
            y=_even(top + (number // columns + 0.5) * pitch - size / 2.0),
            width=size,
            height=size,
            density=density,
        )
        for number, density in enumerate(densities)
    )
    return _painting(table, whole=whole, measured=_middles(whole, table), light=tuple(map(_grey, densities)))


def _middles(whole: tuple[Patch, ...], table: ChartTable) -> tuple[Patch, ...]:
    middles = inset(whole, _EDGE)
    small = next((one for one in middles if min(one.width, one.height) < SMALLEST), None)
    if small is not None:
        raise UsageError(
            f"[chart] patch {small.name} would be {small.width} x {small.height} pixels, too small to be measured; "
            f"allowed: {SMALLEST} or more. Give the camera more pixels, or chart.margin ({table.margin:g}) less."
        )
    return middles


def _painting(
    table: ChartTable, *, whole: tuple[Patch, ...], measured: tuple[Patch, ...], light: tuple[Colour, ...]
) -> Painting:
    darkest = min(min(colour) for colour in light)
    surround = darkest if table.surround is None else 10.0**-table.surround
    return Painting(whole=whole, measured=measured, light=light, surround=surround)


def _densities(table: ChartTable, *, folder: Path) -> tuple[float, ...]:
    """Return the densities of a list, or of the last column of a file."""
    if table.densities is None:
        raise UsageError(
            "chart.densities is missing: a study with a chart says what it shows. Give a list of densities, a file "
            "of them, or the chart.name of a chart."
        )
    if isinstance(table.densities, list):
        return tuple(table.densities)
    path = folder / table.densities
    try:
        lines = [line.strip() for line in path.read_text(encoding="utf-8-sig").splitlines()]
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"The densities {path} cannot be read: {why(error)}.") from error
    found: list[float] = []
    for number, line in enumerate(lines, start=1):
        if not line or line.startswith("#"):
            continue
        word = line.replace(";", ",").split(",")[-1].strip()
        density = _number(word)
        if density is None and not found:
            continue  # a header
        if density is None or not 0.0 <= density <= 10.0:
            raise UsageError(f'{path}: line {number} ends with "{word}"; allowed: a density from 0 to 10.')
        found.append(density)
    if not found:
        raise UsageError(f"{path} holds no density; allowed: lines that end with one, from 0 to 10.")
    return tuple(found)


def _number(word: str) -> float | None:
    try:
        value = float(word)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _grey(density: float | None) -> Colour:
    level = 1.0 if density is None else 10.0**-density
    return (level, level, level)


def _even(value: float) -> int:
    return 2 * round(value / 2.0)
