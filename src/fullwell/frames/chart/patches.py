"""Patches: rectangles of the visible mosaic, from PATCHES.csv (RESULTS 3) or `locate`; read, checked and inset here."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.findings import Finding, Severity, listed

COLUMNS: Final = ("patch", "x", "y", "width", "height", "density")
"""Header of PATCHES.csv; the last column may be missing."""
FEWEST: Final = 5
"""Patches that a noise model of three terms with a black level needs at least, one to spare."""
SMALLEST: Final = 8
"""Least width and height of a patch: 4 x 4 pixels of a plane, ten degrees of freedom [pixel]."""
COMFORTABLE: Final = 400
"""Pixels of a patch below which a finding says that errors are large; 100 of each plane, as METHOD 1.6 counts."""


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
    """Read PATCHES.csv: header ``patch,x,y,width,height,density``, even integers, the density optional.

    Raises
    ------
    UsageError
        With line and column: where the file cannot be read, the header is another one, a number is missing, odd,
        negative or no number, a name stands twice, fewer than five patches are given, or two overlap.

    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [(number, row) for number, row in enumerate(csv.reader(file), start=1) if any(map(str.strip, row))]
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{path} is not a CSV file: {error}.") from error
    header = tuple(name.strip() for name in lines[0][1]) if lines else ()
    if header not in {COLUMNS, COLUMNS[:-1]}:
        raise UsageError(f"{path}: the first line must be {','.join(COLUMNS)}; the density may be left out.")
    seen: dict[str, int] = {}
    patches: list[Patch] = []
    for number, row in lines[1:]:
        patch = _patch(row, header=header, where=f"{path}: line {number}")
        if patch.name in seen:
            raise UsageError(
                f'{path}: line {number}, column patch: "{patch.name}" stands in line {seen[patch.name]} already.'
            )
        seen[patch.name] = number
        patches.append(patch)
    _require_enough(patches, where=f"{path}: ")
    _require_apart(patches, where=f"{path}: ", lines=seen)
    return tuple(patches)


def check_patches(patches: Sequence[Patch], *, width: int, height: int, cell: int) -> tuple[Finding, ...]:
    """Refuse patches that cannot be measured; return what else is to be said about them.

    Parameters
    ----------
    patches
        From PATCHES.csv or a chart.
    width, height
        Of the visible mosaic [pixel].
    cell
        Period of the CFA, which patches must begin and end on [pixel].

    Raises
    ------
    UsageError
        Where fewer than five patches are given, or one is too small, off the CFA's grid, out of the frame or upon
        another.

    """
    _require_enough(patches, where="")
    for one in patches:
        place = f"Patch {one.name} ({one.x},{one.y},{one.width},{one.height})"
        if any(value % cell for value in (one.x, one.y, one.width, one.height)):
            raise UsageError(f"{place} has an odd number: patches begin and end on cells of the colour filter array.")
        if min(one.width, one.height) < SMALLEST:
            raise UsageError(f"{place} is too small: patches have at least {SMALLEST} x {SMALLEST} pixels.")
        if one.x < 0 or one.y < 0 or one.x + one.width > width or one.y + one.height > height:
            raise UsageError(f"{place} reaches out of the visible mosaic, which has {width} x {height} pixels.")
    _require_apart(patches, where="", lines={})
    small = [one.name for one in patches if one.width * one.height < COMFORTABLE]
    if not small:
        return ()
    return (
        Finding(
            code="small-patches",
            severity=Severity.WARNING,
            message=(
                f"Fewer than {COMFORTABLE} pixels in {len(small)} of {len(patches)} patches ({listed(small)}): their "
                "noise is known badly. Show the chart larger."
            ),
        ),
    )


def within(patches: Sequence[Patch], region: tuple[int, int, int, int], *, cell: int) -> tuple[Patch, ...]:
    """Return patches of the whole frame as they lie in a region of it.

    Parameters
    ----------
    patches
        Counted from the top left of the whole visible mosaic.
    region
        x, y, width and height of what is measured, as ``--crop`` has it [pixel].
    cell
        Period of the CFA, which the region has to begin on [pixel].

    Raises
    ------
    UsageError
        Where the region begins between cells, or a patch reaches out of it.

    """
    x, y, width, height = region
    crop = f"--crop {x},{y},{width},{height}"
    if x % cell or y % cell:
        raise UsageError(f"{crop}: give even X and Y; patches begin on cells of the colour filter array.")
    for one in patches:
        if one.x < x or one.y < y or one.x + one.width > x + width or one.y + one.height > y + height:
            place = f"Patch {one.name} ({one.x},{one.y},{one.width},{one.height})"
            raise UsageError(
                f"{place} reaches out of {crop}; both count from the top left of the whole visible mosaic."
            )
    return tuple(replace(one, x=one.x - x, y=one.y - y) for one in patches)


def inset(patches: Sequence[Patch], fraction: float) -> tuple[Patch, ...]:
    """Return the middles of patches, on even pixels.

    Parameters
    ----------
    patches
        Whole patches.
    fraction
        Of width and height, left out on each side; 0 to below 1/2.

    Examples
    --------
    >>> [(one.x, one.width) for one in inset([Patch(name="1", x=10, y=0, width=40, height=40)], 0.2)]
    [(18, 24)]

    """
    if not 0.0 <= fraction < 0.5:
        raise ValueError("an inset leaves something of the patch")

    def middle(start: int, length: int) -> tuple[int, int]:
        first = 2 * math.ceil((start + fraction * length) / 2 - 1e-9)
        last = 2 * math.floor((start + (1.0 - fraction) * length) / 2 + 1e-9)
        return first, max(last - first, 0)

    insets: list[Patch] = []
    for one in patches:
        (x, width), (y, height) = middle(one.x, one.width), middle(one.y, one.height)
        insets.append(replace(one, x=x, y=y, width=width, height=height))
    return tuple(insets)


def _patch(row: Sequence[str], *, header: Sequence[str], where: str) -> Patch:
    if len(row) != len(header):
        raise UsageError(f"{where} has {len(row)} columns, the header has {len(header)}.")
    cells = {name: text.strip() for name, text in zip(header, row, strict=True)}
    if not cells["patch"]:
        raise UsageError(f"{where}, column patch: a patch needs a name.")
    x, y, width, height = (_even(cells[name], where=f"{where}, column {name}") for name in COLUMNS[1:5])
    for name, length in (("width", width), ("height", height)):
        if length < SMALLEST:
            raise UsageError(f"{where}, column {name}: {length} is too small; a patch has at least {SMALLEST} pixels.")
    density = _density(cells.get("density", ""), where=f"{where}, column density")
    return Patch(name=cells["patch"], x=x, y=y, width=width, height=height, density=density)


def _even(text: str, *, where: str) -> int:
    try:
        value = int(text)
    except ValueError:
        raise UsageError(f'{where}: "{text}" is not a whole number of pixels.') from None
    if value < 0:
        raise UsageError(f"{where}: {value} is negative; pixels count from 0 at the visible top left.")
    if value % 2:
        raise UsageError(f"{where}: {value} is odd; patches begin and end on cells of the colour filter array.")
    return value


def _density(text: str, *, where: str) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f'{where}: "{text}" is not a number; leave it empty where no density is known.') from None
    if not math.isfinite(value) or value < 0.0:
        raise UsageError(f"{where}: {text} is not a density, which is 0 or more.")
    return value


def _require_enough(patches: Sequence[Patch], *, where: str) -> None:
    if len(patches) < FEWEST:
        raise UsageError(f"{where}{len(patches)} patches are too few: a noise model needs at least {FEWEST}.")


def _require_apart(patches: Sequence[Patch], *, where: str, lines: dict[str, int]) -> None:
    for one, other in combinations(patches, 2):
        if (
            one.x < other.x + other.width
            and other.x < one.x + one.width
            and one.y < other.y + other.height
            and other.y < one.y + one.height
        ):
            at = f"lines {lines[one.name]} and {lines[other.name]}: " if lines else ""
            raise UsageError(f"{where}{at}the patches {one.name} and {other.name} overlap; their pixels count once.")
