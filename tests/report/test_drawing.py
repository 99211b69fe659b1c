"""Drawings: the same bytes twice, nothing outside of the sheet, nothing upon another, whatever is written."""

import base64
import io
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from PIL import Image

from fullwell.report.drawing import Figure, key
from fullwell.report.drawing.frame import margins
from fullwell.report.drawing.geometry import Box
from fullwell.report.drawing.images import jpeg_uri
from fullwell.report.drawing.pen import Pen
from fullwell.report.drawing.text import width

SVG = "{http://www.w3.org/2000/svg}"


class Texts(Pen):
    """Remembers the box of every text."""

    boxes: list[tuple[str, float, float, float, float]]

    def words(self, text, x, y, *, size, ha="left", va="baseline", rotation=0.0, bold=False, **options):
        wide, high = width(text, size, bold=bold), 0.73 * size
        left = {"left": 0.0, "center": 0.5, "right": 1.0}[ha] * wide
        above = {"baseline": high, "center": high / 2.0, "top": 0.0, "bottom": high}[va]
        box = (x - left, y - above, x - left + wide, y - above + high)
        if rotation:
            box = (x - above, y - wide + left, x - above + high, y + left)
        self.boxes.append((text, *box))
        super().words(text, x, y, size=size, ha=ha, va=va, rotation=rotation, bold=bold, **options)


@pytest.fixture
def texts(monkeypatch):
    Texts.boxes = []
    monkeypatch.setattr("fullwell.report.drawing.figure.Pen", Texts)
    return Texts.boxes


def parsed(figure):
    return ET.fromstring(figure.svg())  # noqa: S314 - a drawing of our own


def decoded(image):
    return Image.open(io.BytesIO(base64.b64decode(image.get("href").partition(",")[2])))


def some_figure(*, scale="linear", top=1.0, rows=1, columns=2, label="Signal above black [DN]"):
    figure = Figure((9.2, 2.4 * rows + 0.3))
    for axes in figure.subplots(rows, columns):
        axes.plot([0.001, 0.5, 1.0], np.array([0.01, 0.3, 1.0]) * top, marker="o", label="a")
        axes.set_xscale(scale)
        axes.set_yscale(scale)
        axes.set(title="Title of the panel", xlabel=label, ylabel=label)
    figure.legend([key("one"), key("another", marker="s", linestyle="none")])
    return figure


@settings(deadline=None, max_examples=40)
@given(
    st.sampled_from(["linear", "log", "powers"]),
    st.floats(1e-7, 1e12),
    st.integers(1, 3),
    st.integers(1, 4),
)
@example("linear", 152453549152.0, 2, 4)  # a label wider than the last panel
def test_no_text_leaves_the_sheet_or_lies_upon_another(scale, top, rows, columns):
    with pytest.MonkeyPatch.context() as patch:
        Texts.boxes = []
        patch.setattr("fullwell.report.drawing.figure.Pen", Texts)
        figure = some_figure(scale=scale, top=top, rows=rows, columns=columns)
        figure.svg()
    boxes = [box for box in Texts.boxes if box[0]]
    for text, left, above, right, below in boxes:
        assert left >= 0.0, text
        assert above >= 0.0, text
        assert right <= figure.width, text
        assert below <= figure.height, text
    for at, (text, left, above, right, below) in enumerate(boxes):
        for other, left2, above2, right2, below2 in boxes[at + 1 :]:
            apart = right <= left2 or right2 <= left or below <= above2 or below2 <= above
            assert apart, (text, other)


def test_the_same_drawing_has_the_same_bytes():
    assert some_figure().svg() == some_figure().svg()


@pytest.mark.parametrize("text", ["<a & b>", '"quoted"', "]]>", "a\nb", "\N{CJK UNIFIED IDEOGRAPH-6F22}", "10^{3}", ""])
def test_any_text_leaves_the_drawing_well_formed(text):
    figure = some_figure(label=text)
    figure.suptitle(text)
    figure.legend([key(text)])
    root = parsed(figure)
    assert root.tag == f"{SVG}svg"
    assert not [one for one in root.iter() if (one.text or "").strip()]


def test_every_use_has_its_definition():
    drawing = some_figure().svg().decode()
    assert set(re.findall(r'href="#(\w+)"', drawing)) <= set(re.findall(r' id="(\w+)"', drawing))


def test_a_gap_parts_a_line():
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    axes.plot([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, np.nan, 1.0, 0.0], color="#123456")
    (path,) = [one for one in parsed(figure).iter(f"{SVG}path") if one.get("stroke") == "#123456"]
    assert path.get("d").count("M") == 2


def test_a_line_of_many_points_looks_the_same_with_few():
    x = np.linspace(0.0, 1.0, 20_000)
    y = np.sin(40.0 * x)
    y[7_000] = 5.0
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    axes.plot(x, y, color="#123456")
    axes.set(xlim=(0.0, 1.0), ylim=(-1.0, 5.0))
    (path,) = [one for one in parsed(figure).iter(f"{SVG}path") if one.get("stroke") == "#123456"]
    places = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.get("d")), float)
    assert len(places) < 6_000
    box = Box(left=places[:, 0].min(), top=0.0, width=np.ptp(places[:, 0]), height=1.0)
    assert places[places[:, 1].argmin(), 0] == pytest.approx(box.left + box.width * x[7_000], abs=0.02)


def test_pixels_of_an_image_are_the_colours_of_its_values():
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    axes.imshow(np.array([[0.0, 1.0, np.nan]]), vmin=0.0, vmax=1.0)
    (image,) = parsed(figure).iter(f"{SVG}image")
    pixels = decoded(image).convert("RGBA")
    assert pixels.size == (3, 1)
    assert pixels.getpixel((0, 0)) == (0x44, 0x01, 0x54, 255)
    assert pixels.getpixel((1, 0)) == (0xFD, 0xE7, 0x25, 255)
    assert pixels.getpixel((2, 0))[3] == 0
    assert float(image.get("width")) == pytest.approx(3.0 * float(image.get("height")), rel=1e-3)


@pytest.mark.parametrize(("interpolation", "kind"), [("nearest", "PNG"), ("smooth", "JPEG")])
def test_colours_are_shown_as_they_are(interpolation, kind):
    colors = np.full((8, 12, 3), (200, 90, 40), np.uint8)
    colors[:, 6:] = (20, 160, 220)
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    axes.imshow(colors, interpolation=interpolation)
    (image,) = parsed(figure).iter(f"{SVG}image")
    shown = decoded(image)
    assert shown.format == kind
    assert np.asarray(shown, float) == pytest.approx(colors.astype(float), abs=0.0 if kind == "PNG" else 12.0)


def test_dense_points_hide_more_where_more_of_them_lie():
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    axes.plot([1.0, 2.0, 2.0, 2.0], [1.0, 2.0, 2.0, 2.0], linestyle="none", marker="s", alpha=0.3, dense=True)
    axes.set(xlim=(0.0, 3.0), ylim=(0.0, 3.0))
    (image,) = parsed(figure).iter(f"{SVG}image")
    opacity = np.asarray(decoded(image).convert("RGBA"))[..., 3] / 255.0
    rows, columns = opacity.shape
    places = [(int(rows * (1.0 - share)), int(columns * share)) for share in (1 / 3, 2 / 3, 0.5)]
    once, thrice, never = (opacity[place] for place in places)
    assert (once, thrice, never) == pytest.approx((0.3, 1.0 - 0.7**3, 0.0), abs=1.0 / 255.0)


def test_facets_are_painted_one_upon_the_other():
    figure = Figure((4.0, 3.0))
    (axes,) = figure.subplots()
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    axes.facets(np.stack([square, 0.5 * square]), np.array([[255, 0, 0], [0, 0, 255]], np.uint8))
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    (image,) = parsed(figure).iter(f"{SVG}image")
    painted = decoded(image).convert("RGBA")
    across, down = painted.size
    assert painted.getpixel((across // 4, 3 * down // 4)) == (0, 0, 255, 255)
    assert painted.getpixel((3 * across // 4, down // 4)) == (255, 0, 0, 255)


@pytest.mark.parametrize("corner", ["upper left", "upper right", "lower left", "lower right"])
def test_the_best_place_of_a_legend_covers_nothing(corner, texts):
    figure = Figure((5.0, 4.0))
    (axes,) = figure.subplots()
    up, right = corner.startswith("upper"), corner.endswith("right")
    taken = [(x, y) for x in (0.1, 0.9) for y in (0.04, 0.96) if (x > 0.5, y > 0.5) != (right, up)]
    for x, y in taken:
        axes.plot(x + np.linspace(-0.1, 0.1, 9), np.full(9, y), label="line" if (x, y) == taken[0] else "")
    axes.plot([0.9, 0.95, 1.0], [0.5, 0.5, 0.5])
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    axes.legend(loc="best")
    figure.svg()
    (place,) = [box for box in texts if box[0] == "line"]
    assert (place[1] > figure.width / 2.0) == right
    assert (place[2] < figure.height / 2.0) == up


def test_what_stands_around_a_panel_takes_its_room():
    axes = some_figure().subplots()[0]
    axes.plot([0.0, 1.0], [0.0, 1.0])
    bare = margins(axes, Box(left=0.0, top=0.0, width=200.0, height=100.0))
    axes.set(title="Two\nlines", xlabel="x", ylabel="y")
    named = margins(axes, Box(left=0.0, top=0.0, width=200.0, height=100.0))
    assert named.top > bare.top
    assert named.left > bare.left
    assert named.bottom > bare.bottom


def test_pure_noise_is_packed_too():
    noise = np.random.default_rng(1).integers(0, 256, (540, 960, 3), dtype=np.uint8)
    packed = base64.b64decode(jpeg_uri(noise).partition(",")[2])
    assert Image.open(io.BytesIO(packed)).size == (960, 540)
