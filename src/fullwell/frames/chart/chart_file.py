"""Charts as TOML files: those that come with Fullwell and one's own.

Coordinates are fractions of the width and height between the chart's corners, counted from its top-left corner, x to
the right and y down. A file holds either a geometry, or the name of a chart whose densities it replaces::

    extends = "dynamic-range-36-grid"  # the chart it is but for its densities
    title = "Our film of May, measured"
    densities = [0.07, 0.18, 0.27, ...]  # one per patch in the chart's order; nan where none is known

A geometry of one's own::

    title = "Our chart"
    aspect = 1.5  # width over height between the corners
    corners = "the outer corners of the four corner patches"
    transmissive = false  # true: lit from behind
    note = "measured with a densitometer in May"
    densities = [0.05, nan, ...]  # or: first_density = 0.05 and density_step = 0.1
    srgb = [[115, 82, 68], ...]  # published 8-bit sRGB of coloured patches, to recognise the chart by

    [grid]  # patches row by row, from the top left
    rows = 4
    columns = 6
    fill = [0.87, 0.87]  # width and height of a patch as a share of its spacing

    [ring]  # or: patches on a circle around the middle
    count = 36
    radius = 0.45  # of their centres
    patch = 0.055  # edge of a patch
    start_degree = 0.0  # the first patch, clockwise from the top

    [[patch]]  # or: each patch by itself
    name = "1"
    x = 0.1  # its centre
    y = 0.5
    width = 0.1
    height = 0.4

A grid's corners are the outer corners of its corner patches; a ring's are those of the square of which its radius is
a fraction. Patches are numbered from 1 where ``names`` does not say otherwise.
"""

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fullwell.errors import UsageError

_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
_Fraction = Annotated[float, Field(gt=0.0, le=1.0)]
_Place = Annotated[float, Field(ge=0.0, le=1.0)]
_Code = Annotated[int, Field(ge=0, le=255)]
_MOST: Final = 400
"""Patches beyond which no chart goes."""
Box = tuple[float, float, float, float]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Grid(_Strict):
    rows: Annotated[int, Field(ge=1, le=_MOST)]
    columns: Annotated[int, Field(ge=1, le=_MOST)]
    fill: Annotated[list[_Fraction], Field(min_length=2, max_length=2)] = [1.0, 1.0]
    layout: list[Annotated[str, Field(pattern="^[x.]+$")]] | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.layout is not None and [len(row) for row in self.layout] != [self.columns] * self.rows:
            raise ValueError("layout has a character for every column in a string for every row")
        return self

    def boxes(self, aspect: float) -> list[Box]:
        """Return centre, width and height of each patch, row by row; the aspect of the chart does not matter."""
        del aspect
        across, down = self.fill
        x_step, y_step = 1.0 / (self.columns - 1 + across), 1.0 / (self.rows - 1 + down)
        width, height = across * x_step, down * y_step
        return [
            (column * x_step + width / 2, row * y_step + height / 2, width, height)
            for row in range(self.rows)
            for column in range(self.columns)
            if self.layout is None or self.layout[row][column] == "x"
        ]


class _Ring(_Strict):
    count: Annotated[int, Field(ge=3, le=_MOST)]
    radius: Annotated[float, Field(gt=0.0, le=0.5)]
    patch: _Fraction
    start_degree: Annotated[float, Field(allow_inf_nan=False)] = 0.0

    def boxes(self, aspect: float) -> list[Box]:
        """Return centre, width and height of each patch, clockwise."""
        angles = [math.radians(self.start_degree + 360.0 * one / self.count) for one in range(self.count)]
        width = self.patch / aspect
        return [
            (
                0.5 + self.radius / aspect * math.sin(angle),
                0.5 - self.radius * math.cos(angle),
                width,
                self.patch,
            )
            for angle in angles
        ]


class _Patch(_Strict):
    name: str
    x: _Place
    y: _Place
    width: _Fraction
    height: _Fraction


class ChartFile(_Strict):
    """What a chart's file says; see the module for the keys."""

    title: str
    aspect: _Positive = 1.0
    corners: str = "the corners of the chart"
    transmissive: bool = False
    note: str = ""
    extends: str | None = None
    grid: _Grid | None = None
    ring: _Ring | None = None
    patch: list[_Patch] = []
    names: list[str] | None = None
    densities: list[float] | None = None
    first_density: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] | None = None
    density_step: _Positive | None = None
    srgb: list[Annotated[list[_Code], Field(min_length=3, max_length=3)]] | None = None

    def require_densities_alone(self, path: Path) -> None:
        """Refuse a file that extends a chart and says more than title, note and densities."""
        more = self.model_fields_set - {"extends", "title", "note", "densities", "first_density", "density_step"}
        if more:
            raise UsageError(
                f"{path}: {', '.join(sorted(more))} cannot stand beside extends, which replaces nothing but densities."
            )

    def geometry(self, path: Path) -> tuple[list[Box], list[str]]:
        """Return centre, width and height of each patch, as fractions between the corners, and its name."""
        forms = [form for form in (self.grid, self.ring, self.patch) if form]
        if len(forms) != 1:
            raise UsageError(f"{path}: a chart has either [grid], [ring], [[patch]] or extends.")
        if self.patch:
            return [(one.x, one.y, one.width, one.height) for one in self.patch], [one.name for one in self.patch]
        form = self.grid or self.ring
        boxes = form.boxes(self.aspect) if form else []
        names = self.names or [str(number) for number in range(1, len(boxes) + 1)]
        _require_length(names, count=len(boxes), key="names", path=path)
        return boxes, names

    def optical_densities(self, count: int, path: Path) -> list[float | None]:
        """Return the density of each of ``count`` patches, None where it is not known."""
        if self.densities is not None:
            _require_length(self.densities, count=count, key="densities", path=path)
            if any(one < 0.0 or math.isinf(one) for one in self.densities):
                raise UsageError(f"{path}: densities are 0 or more, or nan where none is known.")
            return [None if math.isnan(one) else one for one in self.densities]
        if self.first_density is None or self.density_step is None:
            return [None] * count
        return [round(self.first_density + number * self.density_step, 6) for number in range(count)]

    def colours(self, densities: Sequence[float | None], path: Path) -> list[tuple[float, float, float]]:
        """Return the linear colour of each patch, from srgb or else from its density."""
        if self.srgb is not None:
            _require_length(self.srgb, count=len(densities), key="srgb", path=path)
            linear = [[_linear(code / 255.0) for code in codes] for codes in self.srgb]
            return [(red, green, blue) for red, green, blue in linear]
        if any(density is None for density in densities):
            raise UsageError(f"{path}: a chart needs the density of every patch, or srgb, to be recognised by.")
        return [grey(density) for density in densities if density is not None]


def read_chart_file(path: Path) -> ChartFile:
    """Read a chart's TOML file.

    Raises
    ------
    UsageError
        Where the file cannot be read or says something that is not allowed.

    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise UsageError(f"Cannot read {path}: {error.strerror}.") from error
    except ValueError as error:
        raise UsageError(f"{path} is not valid TOML: {error}.") from error
    try:
        return ChartFile.model_validate(document)
    except ValidationError as error:
        wrong = error.errors()[0]
        key = ".".join(str(part + 1) if isinstance(part, int) else part for part in wrong["loc"])
        raise UsageError(f"{path}: {key} is not as it should be: {wrong['msg'].lower()}.") from error


def grey(density: float) -> tuple[float, float, float]:
    """Return the linear colour of a neutral patch."""
    value = 10.0**-density
    return value, value, value


def _linear(value: float) -> float:
    """Return the linear value of an sRGB value, both 0 to 1 (IEC 61966-2-1)."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def _require_length(values: Sequence[object], *, count: int, key: str, path: Path) -> None:
    if len(values) != count:
        raise UsageError(f"{path}: {key} has {len(values)} entries for {count} patches.")
