"""What a chart looks like: its patches in a unit square, their densities and what helps to recognise it."""

from dataclasses import dataclass


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
        Of the printed patch, as such fractions; what is measured lies well inside.
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
    patches
        In the order of its numbers.
    note
        Where its densities come from.

    """

    name: str
    title: str
    aspect: float
    patches: tuple[ChartPatch, ...]
    note: str = ""


def chart_names() -> tuple[str, ...]:
    """Return the names of the charts that come with Fullwell."""
    raise NotImplementedError


def chart_named(name: str) -> ChartDefinition:
    """Return a chart that comes with Fullwell, or one's own from the TOML file of that path."""
    raise NotImplementedError
