"""Texts: widths and outlines are those of the font, as fontTools reads it."""

import re
from itertools import pairwise

import pytest
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont

from fullwell.report.drawing.text import FONTS, face, plain, set_line, width


@pytest.fixture(scope="module", params=[False, True], ids=["regular", "bold"])
def faces(request):
    name = "DejaVuSans-Bold.ttf" if request.param else "DejaVuSans.ttf"
    return face(bold=request.param), TTFont(FONTS / name)


def points_of(path):
    return {tuple(map(float, pair)) for pair in re.findall(r"(-?[\d.]+) (-?[\d.]+)", path)}


def points_by_font_tools(glyphs, name):
    """Return the points of an outline, those in the middle of two that it only bends towards too."""
    pen = DecomposingRecordingPen(glyphs)
    glyphs[name].draw(pen)
    found = set()
    for verb, points in pen.value:
        found |= {point for point in points if point is not None}
        if verb == "qCurveTo":
            bends = [*points[:-1], points[0]] if points[-1] is None else points[:-1]
            found |= {((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0) for a, b in pairwise(bends)}
    return found


def test_every_character_has_the_glyph_the_width_and_the_outline_of_the_font(faces):
    own, other = faces
    glyphs, order = other.getGlyphSet(), other.getReverseGlyphMap()
    for code, name in other.getBestCmap().items():
        glyph = own.glyph(chr(code))
        assert glyph == order[name]
        assert own.advance(glyph) == other["hmtx"][name][0]
        ours, theirs = points_of(own.outline(glyph)), points_by_font_tools(glyphs, name)
        assert ours == {(round(x, 3), round(y, 3)) for x, y in theirs}, name


def test_pairs_are_kerned_as_the_font_says(faces):
    own, other = faces
    pairs = other["kern"].kernTables[0].kernTable
    order = other.getReverseGlyphMap()
    for (left, right), value in list(pairs.items())[:500]:
        assert own.kerning(order[left], order[right]) == value
    assert width("AV", 100.0) < width("A", 100.0) + width("V", 100.0)


def test_a_character_that_the_font_lacks_is_a_box_and_no_error():
    assert set_line("\N{CJK UNIFIED IDEOGRAPH-6F22}").glyphs[0].glyph == 0


def test_raised_and_lowered_parts_are_small_and_off_the_line():
    line = set_line("10^{3}k_{d}")
    one, zero, three, letter, lowered = line.glyphs
    assert one.y == zero.y == letter.y == 0.0
    assert three.y > 0.0 > lowered.y
    assert three.scale == lowered.scale < 1.0
    assert line.width < set_line(plain("10^{3}k_{d}")).width


def test_the_widest_line_counts():
    assert width("a\nwwww\nb", 9.0) == width("wwww", 9.0)
