"""What an SVG is written with: paths, stamps, images and texts as outlines, the same bytes for the same strokes."""

from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np

from fullwell.report.drawing.geometry import Array, Box
from fullwell.report.drawing.style import INK, Across, LineStyle, Up, dashes_of
from fullwell.report.drawing.text import CAPITAL, DEPTH, LINE_HEIGHT, Placed, face, set_line

_HALO: Final = 2.4
"""Width of the line around letters that stand on a picture."""


class Pen:
    """Draws on a sheet of ``width`` by ``height`` [point]."""

    def __init__(self, width: float, height: float) -> None:
        self._size = (width, height)
        self._body: list[str] = []
        self._shared: dict[str, str] = {}

    def path(
        self,
        path: str,
        *,
        stroke: str = "none",
        width: float = 1.0,
        style: LineStyle = "-",
        fill: str = "none",
        alpha: float = 1.0,
        cap: str = "butt",
    ) -> None:
        """Draw an SVG path."""
        if path:
            said = _look(stroke=stroke, width=width, style=style, fill=fill, alpha=alpha, cap=cap)
            self._body.append(f'<path d="{path}"{said}/>')

    def line(self, x1: float, y1: float, x2: float, y2: float, *, stroke: str, width: float) -> None:
        """Draw a straight line."""
        self.path(f"M{number(x1)} {number(y1)}L{number(x2)} {number(y2)}", stroke=stroke, width=width)

    def box(
        self, box: Box, *, fill: str = "none", stroke: str = "none", width: float = 1.0, alpha: float = 1.0
    ) -> None:
        """Draw a rectangle."""
        self.path(rectangle_path(box), fill=fill, stroke=stroke, width=width, alpha=alpha)

    def stamps(
        self, outline: str, x: Array, y: Array, *, stroke: str, width: float, fill: str, alpha: float = 1.0
    ) -> None:
        """Draw one outline, given about the origin, at every place."""
        if not x.size:
            return
        key = self._share(f'<path d="{outline}"/>')
        places = np.round(np.column_stack([x, y]), 2) + 0.0
        uses = (f'<use href="#{key}" x="%.6g" y="%.6g"/>' * len(places)) % tuple(places.ravel().tolist())
        said = _look(stroke=stroke, width=width, style="-", fill=fill, alpha=alpha, cap="butt")
        self._body.append(f"<g{said}>{uses}</g>")

    def words(
        self,
        text: str,
        x: float,
        y: float,
        *,
        size: float,
        color: str = INK,
        bold: bool = False,
        ha: Across = "left",
        va: Up = "baseline",
        rotation: float = 0.0,
        halo: str = "",
    ) -> None:
        """Write a text; ``halo`` is the colour of a line around its letters.

        Parameters
        ----------
        text
            Lines of text.
        x, y
            Where its point of `ha` and `va` stands.
        size
            Of its letters [point].
        color, bold, ha, va, halo
            Its look.
        rotation
            Anticlockwise, about that point [degree].

        """
        turned = f"rotate({number(-rotation)})" if rotation else ""
        scale = size / face(bold=bold).units
        lines = text.split("\n")
        first = _first_baseline(va, len(lines))
        glyphs: list[str] = []
        for index, line in enumerate(lines):
            row = set_line(line, bold=bold)
            start = {"left": 0.0, "center": -0.5, "right": -1.0}[ha] * row.width
            fall = first + LINE_HEIGHT * index
            glyphs += [self._glyph(one, start, fall, bold=bold) for one in row.glyphs]
        drawn = "".join(glyphs)
        if not drawn:
            return
        place = f'transform="translate({number(x)} {number(y)}){turned}scale({scale:.5g} {-scale:.5g})"'
        if halo:
            wide = number(_HALO / scale)
            self._body.append(
                f'<g {place} fill="none" stroke="{halo}" stroke-width="{wide}" stroke-linejoin="round">{drawn}</g>'
            )
        self._body.append(f'<g {place} fill="{color}">{drawn}</g>')

    def image(self, uri: str, box: Box, *, crisp: bool) -> None:
        """Draw a picture given as a data URI, its pixels kept as they are if ``crisp``."""
        rendering = ' style="image-rendering:pixelated"' if crisp else ""
        self._body.append(
            f'<image x="{number(box.left)}" y="{number(box.top)}" width="{number(box.width)}" '
            f'height="{number(box.height)}" preserveAspectRatio="none"{rendering} href="{uri}"/>'
        )

    @contextmanager
    def clipped(self, box: Box) -> Generator[None]:
        """Show only what lies in a box."""
        key = self._share(f'<path d="{rectangle_path(box)}"/>', kind="clipPath")
        start = len(self._body)
        yield
        if len(self._body) > start:
            self._body.insert(start, f'<g clip-path="url(#{key})">')
            self._body.append("</g>")

    def drawing(self) -> bytes:
        """Return the SVG."""
        width, height = (number(one) for one in self._size)
        shared = "".join(self._shared.values())
        return (
            '<?xml version="1.0" encoding="utf-8"?>'
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="{height}pt" '
            f'viewBox="0 0 {width} {height}"><defs>{shared}</defs>{"".join(self._body)}</svg>'
        ).encode()

    def _glyph(self, one: Placed, start: float, fall: float, *, bold: bool) -> str:
        """Return a glyph in the units of its face, y upwards, ``fall`` below the line."""
        font = face(bold=bold)
        key = f"{'b' if bold else 'r'}{one.glyph}"
        if key not in self._shared:
            outline = font.outline(one.glyph)
            self._shared[key] = f'<path id="{key}" d="{outline}"/>' if outline else ""
        if not self._shared[key]:
            return ""
        x, y = round(font.units * (start + one.x)), round(font.units * (one.y - fall))
        if one.scale != 1.0:
            return f'<use href="#{key}" transform="translate({x} {y})scale({one.scale})"/>'
        return f'<use href="#{key}" x="{x}"/>' if not y else f'<use href="#{key}" x="{x}" y="{y}"/>'

    def _share(self, content: str, *, kind: str = "") -> str:
        """Define content once and return its name."""
        name = f"{kind}{content}"
        if name not in self._shared:
            key = f"{'c' if kind else 'm'}{len(self._shared)}"
            self._shared[name] = (
                f'<{kind} id="{key}">{content}</{kind}>' if kind else content.replace("<path", f'<path id="{key}"')
            )
            return key
        return self._shared[name].split('"', 2)[1]


def number(value: float) -> str:
    """Return a length to a hundredth of a point.

    Examples
    --------
    >>> number(-0.001), number(12.3456), number(200.0)
    ('0', '12.35', '200')

    """
    return f"{round(value, 2) + 0.0:.7g}"


def polyline(x: Array, y: Array) -> str:
    """Return the path through points, which NaN part."""
    return "".join(_line(_rounded(*piece)) for piece in _pieces(x, y))


def polygon(x: Array, y: Array) -> str:
    """Return the closed path through points, all of them known."""
    places = _rounded(x, y)
    return f"M{_listed(places)}Z" if len(places) else ""


def _line(places: Array) -> str:
    """Return an open path: of steps each is one number."""
    level, upright = (np.diff(places[:, along]) == 0.0 for along in (1, 0))
    if not np.all(level | upright):
        return f"M{_listed(places)}"
    turns = "".join("H%.6g" if one else "V%.6g" for one in level.tolist())
    return f"M{_listed(places[:1])}" + turns % tuple(np.where(level, places[1:, 0], places[1:, 1]).tolist())


def _rounded(x: Array, y: Array) -> Array:
    return np.round(np.column_stack([x, y]), 2) + 0.0


def _listed(places: Array) -> str:
    return (("L%.6g %.6g" * len(places)) % tuple(places.ravel().tolist()))[1:]


def rectangle_path(box: Box) -> str:
    """Return the path around a box."""
    left, right, top, bottom = (number(one) for one in (box.left, box.right, box.top, box.bottom))
    return f"M{left} {top}H{right}V{bottom}H{left}Z"


def lines_path(ends: Iterable[Sequence[float]]) -> str:
    """Return the path of separate lines, each given as x1, y1, x2, y2."""
    return "".join(f"M{number(x1)} {number(y1)}L{number(x2)} {number(y2)}" for x1, y1, x2, y2 in ends)


def _pieces(x: Array, y: Array) -> list[tuple[Array, Array]]:
    known = np.isfinite(x) & np.isfinite(y)
    if known.all():
        return [(x, y)] if x.size > 1 else []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    return [(x[a:b], y[a:b]) for a, b in edges.reshape(-1, 2).tolist() if b - a > 1]


def _first_baseline(va: Up, lines: int) -> float:
    """Return how far the first line of a text stands below its place [em]."""
    more = LINE_HEIGHT * (lines - 1)
    return {
        "baseline": 0.0,
        "top": CAPITAL,
        "center": 0.5 * (CAPITAL - more),
        "bottom": -DEPTH - more,
    }[va]


def _look(*, stroke: str, width: float, style: LineStyle, fill: str, alpha: float, cap: str) -> str:
    """Return the attributes of a line and an area."""
    said = f' fill="{fill}"'
    if stroke != "none":
        said += f' stroke="{stroke}" stroke-width="{number(width)}" stroke-linejoin="round"'
        if cap != "butt":
            said += f' stroke-linecap="{cap}"'
        if dashes := dashes_of(style):
            said += f' stroke-dasharray="{" ".join(number(width * dash) for dash in dashes)}"'
    return said if alpha == 1.0 else f'{said} opacity="{alpha:g}"'
