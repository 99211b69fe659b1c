"""The look of every picture: colours and sizes; lengths are points, 72 to an inch, unless their name says otherwise."""

from typing import Final, Literal, TypeAlias

INK: Final = "#1f2933"
QUIET: Final = "#7b8794"
PAPER: Final = "#ffffff"
SPINE: Final = "#b8c2cc"
GRID: Final = "#e6eaee"
TICK: Final = "#52606d"

SMALL: Final = 8.0
"""Letters of tick labels."""
LETTERS: Final = 9.0
"""Letters of labels and notes."""
TITLE: Final = 9.5
LEGEND: Final = 8.5

LINE: Final = 1.4
SPINE_WIDTH: Final = 0.8
GRID_WIDTH: Final = 0.7
MARKER: Final = 4.0

LineStyle: TypeAlias = Literal["-", "--", ":", "-.", "none", ""] | tuple[float, ...]
"""Solid, dashed, dotted, both, none; or lengths of dashes and gaps in widths of the line."""

Marker: TypeAlias = Literal["", "o", "s", "D", "^", "P", "x", "+", "*", "."]
Fill: TypeAlias = Literal["full", "none", "left", "bottom"]
Across: TypeAlias = Literal["left", "center", "right"]
Up: TypeAlias = Literal["baseline", "bottom", "center", "top"]

_DASHES: Final = (("--", (3.7, 1.6)), (":", (1.0, 1.65)), ("-.", (6.4, 1.6, 1.0, 1.6)))


def dashes_of(style: LineStyle) -> tuple[float, ...]:
    """Return the lengths of dashes and gaps in widths of the line; none for a solid line."""
    return style if isinstance(style, tuple) else dict(_DASHES).get(style, ())


def is_drawn(style: LineStyle) -> bool:
    """Tell whether there is a line at all."""
    return style not in ("none", "")
