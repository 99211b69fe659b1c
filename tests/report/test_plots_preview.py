"""Sheets of raw files: what is written and drawn on them, as it becomes a PNG."""

import io
import re

import numpy as np
import pytest
from drawn import lines, photographs
from PIL import Image

from fullwell.report import plots_preview
from fullwell.report.drawing import rgb
from fullwell.report.drawing.style import INK
from fullwell.report.plots import Picture, color_of, picture_of
from fullwell.report.plots_preview import OrderView, Plane, Preview, orders_png, preview_png

CHANNELS = ("R", "G1", "G2", "B")


def plane(channel: str, *, black: float | None = 64.0, white: float | None = 1023.0, size: int = 300) -> Plane:
    counts = np.zeros(1000, np.int64)
    counts[60:900] = 10
    counts[999] = 3
    image = np.full((size // 2, size), 0.5, np.float32)
    return Plane(channel=channel, image=image, counts=counts, black_level=black, white_level=white)


def preview(planes: tuple[Plane, ...]) -> Preview:
    picture = np.zeros((200, 320, 3), np.float32)
    picture[..., 0] = 1.0
    return Preview(title="a.dng", subtitle="Camera", picture=picture, caption="as it is", planes=planes)


@pytest.fixture
def sheets(monkeypatch: pytest.MonkeyPatch) -> list[Picture]:
    """Return the drawings that become PNGs from now on."""
    drawn: list[Picture] = []
    printed = plots_preview.png_of

    def remember(drawing: bytes, *, per_inch: float) -> bytes:
        drawn.append(picture_of(drawing, alt="", caption=""))
        return printed(drawing, per_inch=per_inch)

    monkeypatch.setattr(plots_preview, "png_of", remember)
    return drawn


def test_a_sheet_is_a_png_with_picture_planes_and_codes(words: list[str], sheets: list[Picture]) -> None:
    shown = Image.open(io.BytesIO(preview_png(preview(tuple(plane(name) for name in CHANNELS)))))
    assert (shown.format, shown.size) == ("PNG", (1690, 1222))
    assert words[:2] == ["a.dng", "Camera"]
    assert {"Picture", "as it is", *(f"Plane {name}" for name in CHANNELS)} <= set(words)
    assert {"Codes", "Codes near black", "pixels", "black level", "white level"} <= set(words)
    picture, *planes = photographs(sheets[0])
    assert np.abs(picture - (255.0, 0.0, 0.0)).max() < 4.0
    assert len(planes) == 4
    middle = np.array([one[75, 150] for one in planes])
    assert middle == pytest.approx(np.array([rgb(color_of(name)) for name in CHANNELS], float), abs=1.0)


@pytest.mark.parametrize(("black", "white", "levels"), [(64.0, 1023.0, 3), (64.0, None, 2), (None, None, 0)])
def test_levels_are_drawn_where_they_are_known(
    black: float | None, white: float | None, levels: int, words: list[str], sheets: list[Picture]
) -> None:
    preview_png(preview((plane("mono", black=black, white=white, size=90),)))
    assert len(lines(sheets[0], stroke=color_of("mono"), dashed=True)) == levels
    assert ("black level" in words) == (black is not None)
    assert ("white level" in words) == (white is not None)
    assert len(lines(sheets[0], stroke=INK, dashed=True)) == (black is not None) + (white is not None)
    assert "Centre, pixel by pixel" in words


def test_both_panels_of_codes_have_one_ordinate(words: list[str], sheets: list[Picture]) -> None:
    preview_png(preview((plane("mono"),)))
    assert words.count("10") == 1
    steps = lines(sheets[0], stroke=color_of("mono"), dashed=False)
    _, whole, near = ({float(y) for y in re.findall(r" (-?[\d.]+)", path)} for path in steps)
    assert near < whole


def test_orders_stand_side_by_side_with_their_details_below(words: list[str], sheets: list[Picture]) -> None:
    detail = np.full((48, 48, 3), (0.0, 1.0, 0.0), np.float32)
    views = [OrderView(order=one, picture=np.zeros((300, 400, 3), np.float32), detail=detail) for one in "abcd"]
    shown = Image.open(io.BytesIO(orders_png("a.dng", "Choose by eye.", views)))
    assert (shown.format, shown.size) == ("PNG", (1690, 858))
    found = photographs(sheets[0])
    assert [one.shape[:2] for one in found] == [(300, 400)] * 4 + [(48, 48)] * 4
    assert sum((one == (0.0, 255.0, 0.0)).all() for one in found) == 4
    assert [word for word in words if len(word) == 1] == ["a", "b", "c", "d"]
    assert words.count("detail, pixel by pixel") == 4
