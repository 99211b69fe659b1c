"""Texts as outlines: how wide they are, and where each glyph stands. ``^{2}`` raises, ``_{min}`` lowers."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

from fullwell.report.drawing.truetype import Face

FONTS: Final = Path(__file__).parents[1] / "fonts"
LINE_HEIGHT: Final = 1.2
"""From one line of a text to the next [em]."""
CAPITAL: Final = 0.73
"""Height of capitals and figures [em]."""
DEPTH: Final = 0.24
"""What hangs below the line [em]."""

_SCRIPT: Final = re.compile(r"(\^|_)\{([^}]*)\}")
_SCRIPT_SIZE: Final = 0.7
_RAISED: Final = 0.38
_LOWERED: Final = -0.16


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """A glyph of a line.

    Parameters
    ----------
    glyph
        Its number in the face.
    x, y
        From the beginning of the line, y upwards [em].
    scale
        Of its size [1].

    """

    glyph: int
    x: float
    y: float
    scale: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A line of text with its width [em]."""

    glyphs: tuple[Placed, ...]
    width: float


@cache
def face(*, bold: bool) -> Face:
    """Return the face that texts are set in."""
    return Face(FONTS / f"DejaVuSans{'-Bold' if bold else ''}.ttf")


@lru_cache(maxsize=4096)
def set_line(text: str, *, bold: bool = False) -> Line:
    """Return a line of text, set."""
    font = face(bold=bold)
    glyphs: list[Placed] = []
    pen = 0.0
    for part, scale, y in _parts(text):
        before = None
        for glyph in map(font.glyph, part):
            pen += 0.0 if before is None else scale * font.kerning(before, glyph) / font.units
            glyphs.append(Placed(glyph=glyph, x=pen, y=y, scale=scale))
            pen += scale * font.advance(glyph) / font.units
            before = glyph
    return Line(glyphs=tuple(glyphs), width=pen)


def width(text: str, size: float, *, bold: bool = False) -> float:
    """Return the width of the widest line of a text [point]."""
    return size * max(set_line(line, bold=bold).width for line in text.split("\n"))


def height(text: str, size: float) -> float:
    """Return the height of a text from the capitals of its first line to what hangs below the last [point]."""
    return size * (CAPITAL + DEPTH + LINE_HEIGHT * text.count("\n"))


def plain(text: str) -> str:
    """Return a text without what only sets it.

    Examples
    --------
    >>> plain("10^{3} k_{dark}")
    '103 kdark'

    """
    return _SCRIPT.sub(r"\2", text)


def _parts(text: str) -> Iterator[tuple[str, float, float]]:
    """Yield pieces with their size and how far they are raised [em]."""
    end = 0
    for match in _SCRIPT.finditer(text):
        yield text[end : match.start()], 1.0, 0.0
        yield match[2], _SCRIPT_SIZE, _RAISED if match[1] == "^" else _LOWERED
        end = match.end()
    yield text[end:], 1.0, 0.0
