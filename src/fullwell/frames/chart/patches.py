"""Patches: rectangles of the visible mosaic, from PATCHES.csv or found by `locate`; read, checked and inset here."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fullwell.findings import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class Patch:
    """One patch of a chart in a frame.

    Parameters
    ----------
    name
        As the chart or PATCHES.csv has it.
    x, y, width, height
        Even, counted from the visible top-left pixel [pixel].
    density
        Optical density relative to a perfect white, None where nobody knows it.

    """

    name: str
    x: int
    y: int
    width: int
    height: int
    density: float | None = None


def read_patches(path: Path) -> tuple[Patch, ...]:
    """Read PATCHES.csv."""
    raise NotImplementedError


def check_patches(patches: Sequence[Patch], *, width: int, height: int, cell: int) -> tuple[Finding, ...]:
    """Refuse patches that cannot be measured; return what else is to be said about them."""
    raise NotImplementedError


def inset(patches: Sequence[Patch], fraction: float) -> tuple[Patch, ...]:
    """Return the middles of patches: ``fraction`` of width and height is left out on each side."""
    raise NotImplementedError
