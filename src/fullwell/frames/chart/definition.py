"""What a chart looks like: its patches in a unit square, their densities and what helps to recognise it."""

from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.frames.chart.chart_file import ChartFile, grey, read_chart_file
from fullwell.frames.chart.patches import FEWEST

_NAMES: Final = (
    "colorchecker-classic",
    "colorchecker-passport",
    "stouffer-t4110",
    "dynamic-range-36-ring",
    "dynamic-range-36-grid",
)
_TOUCHING: Final = 1.05
"""Spacing over size of patches, below which no gap can be seen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartPatch:
    """One patch of a chart as printed.

    Parameters
    ----------
    name
        What rows and pictures call it.
    x, y
        Its centre, as fractions of the width and height between the chart's corners; x to the right, y down.
    width, height
        Of the whole patch, as such fractions; what is measured lies well inside.
    density
        Optical density, None where nothing is published.
    rgb
        Its linear colour relative to a perfect white, for recognition only.

    """

    name: str
    x: float
    y: float
    width: float
    height: float
    density: float | None
    rgb: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartDefinition:
    """A chart.

    Parameters
    ----------
    name
        What ``--chart`` calls it.
    title
        For people.
    aspect
        Width over height between its corners.
    corners
        What its corners are, for people who give them.
    transmissive
        Lit from behind, so that it may hang with its back to the camera.
    patches
        In the order of its numbers.
    note
        Where its densities come from.

    """

    name: str
    title: str
    aspect: float
    corners: str
    transmissive: bool
    patches: tuple[ChartPatch, ...]
    note: str = ""

    @property
    def coloured(self) -> bool:
        """Whether any patch is other than grey."""
        return any(len(set(one.rgb)) > 1 for one in self.patches)

    @property
    def in_line(self) -> bool:
        """Whether all patches stand in one row or one column."""
        return bool(np.ptp(self.centres, axis=0).min() < 1e-6)

    @property
    def touching(self) -> bool:
        """Whether patches stand side by side without a gap that could be seen."""
        apart = np.abs(self.centres[:, None] - self.centres[None, :]) / self.sizes
        beside = (apart > 0.5) | (apart < 0.05)
        near = np.where(beside.all(axis=2), apart.sum(axis=2), np.inf)
        np.fill_diagonal(near, np.inf)
        return bool(np.median(near.min(axis=1)) < _TOUCHING)

    @property
    def centres(self) -> NDArray[np.float64]:
        """Centres of the patches, shape (patches, 2), as fractions of width and height."""
        return np.array([(one.x, one.y) for one in self.patches])

    @property
    def sizes(self) -> NDArray[np.float64]:
        """Width and height of the patches, shape (patches, 2), as such fractions."""
        return np.array([(one.width, one.height) for one in self.patches])

    @property
    def colours(self) -> NDArray[np.float64]:
        """Linear red, green and blue of the patches, shape (patches, 3)."""
        return np.array([one.rgb for one in self.patches])


def chart_names() -> tuple[str, ...]:
    """Return the names of the charts that come with Fullwell."""
    return _NAMES


def chart_named(name: str) -> ChartDefinition:
    """Return a chart that comes with Fullwell, or one's own from the TOML file of that path.

    Raises
    ------
    UsageError
        Where there is no such chart, or the file says something that is not allowed.

    Examples
    --------
    >>> chart = chart_named("colorchecker-classic")
    >>> len(chart.patches), chart.patches[18].density, chart.patches[0].density
    (24, 0.05, None)

    """
    if name in _NAMES:
        return _own(name)
    path = Path(name)
    if path.suffix == ".toml":
        return _read(path)
    raise UsageError(
        f'There is no chart "{name}". Fullwell knows {", ".join(_NAMES)}; a chart of your own is a TOML file, whose '
        "name ends with .toml."
    )


@cache
def _own(name: str) -> ChartDefinition:
    return _read(Path(str(files("fullwell.frames.chart") / "charts" / f"{name}.toml")))


def _read(path: Path) -> ChartDefinition:
    chart = read_chart_file(path)
    if chart.extends is not None:
        return _extended(chart, path=path)
    boxes, names = chart.geometry(path)
    if len(boxes) < FEWEST:
        raise UsageError(f"{path}: a chart has at least {FEWEST} patches, this one {len(boxes)}.")
    if len(set(names)) < len(names):
        raise UsageError(f"{path}: two patches have the same name.")
    densities = chart.optical_densities(len(boxes), path)
    colours = chart.colours(densities, path)
    patches = tuple(
        ChartPatch(name=name, x=x, y=y, width=width, height=height, density=density, rgb=rgb)
        for name, (x, y, width, height), density, rgb in zip(names, boxes, densities, colours, strict=True)
    )
    return ChartDefinition(
        name=path.stem,
        title=chart.title,
        aspect=chart.aspect,
        corners=chart.corners,
        transmissive=chart.transmissive,
        patches=patches,
        note=chart.note,
    )


def _extended(chart: ChartFile, *, path: Path) -> ChartDefinition:
    if chart.extends not in _NAMES:
        raise UsageError(f'{path}: extends = "{chart.extends}" is no chart; there are {", ".join(_NAMES)}.')
    chart.require_densities_alone(path)
    base = _own(chart.extends)
    densities = chart.optical_densities(len(base.patches), path)
    if all(density is None for density in densities):
        raise UsageError(f"{path}: a chart that extends another one states its densities.")
    patches = tuple(
        replace(one, density=density, rgb=one.rgb if base.coloured or density is None else grey(density))
        for one, density in zip(base.patches, densities, strict=True)
    )
    return replace(base, name=path.stem, title=chart.title, patches=patches, note=chart.note)
