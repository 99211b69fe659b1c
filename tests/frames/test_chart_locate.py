"""Charts are found wherever they lie, and nothing else is taken for one."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from chart_pictures import (
    BLACK,
    WHITE,
    Corners,
    draw_chart,
    photograph,
    textured_scene,
    true_corners_of_patches,
    turned_corners,
)
from numpy.typing import NDArray

from fullwell.frames.chart.definition import ChartDefinition, chart_named
from fullwell.frames.chart.locate import CONFIDENCE, Located, locate
from fullwell.raw.open import read_raw

Locate = Callable[..., Located]
DATA = Path(os.environ.get("FULLWELL_DATA", Path(__file__).parents[3] / "shared/data"))
OPAQUE = 1e-5
"""Transmittance of the mask around a chart that is lit from behind."""


def picture(
    definition: ChartDefinition,
    corners: Corners,
    *,
    seed: int = 1,
    shape: tuple[int, int] = (800, 1200),
    surround: float = 0.04,
    **camera: float | str,
) -> NDArray[np.uint16]:
    rng = np.random.default_rng(seed)
    scene = textured_scene(rng, *shape)
    draw_chart(scene, definition, corners, surround=surround)
    return photograph(scene, rng, **camera)


def found(mosaic: NDArray[np.uint16], definition: ChartDefinition, cfa: str = "RGGB", **options: Corners) -> Located:
    return locate(mosaic, cfa=cfa, black=BLACK, white=WHITE, definition=definition, **options)


def assert_on_their_patches(located: Located, definition: ChartDefinition, corners: Corners, *, darkest: float = 9.0):
    """Every rectangle, on even pixels, lies inside the true patch, at least 0.12 of its edge away from its border."""
    assert located.confidence >= CONFIDENCE, located.reason
    assert located.reason == ""
    assert [one.name for one in located.patches] == [one.name for one in definition.patches]
    assert [one.density for one in located.patches] == [one.density for one in definition.patches]
    for one, printed, border in zip(
        located.patches, definition.patches, true_corners_of_patches(definition, corners, share=0.76), strict=True
    ):
        assert one.x % 2 == one.y % 2 == one.width % 2 == one.height % 2 == 0
        if (printed.density or 0.0) > darkest:
            continue
        x, y = (one.x, one.x + one.width), (one.y, one.y + one.height)
        rectangle = np.array([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])], dtype=float)
        assert inside(rectangle, border), f"{one} is not within {border.round(1).tolist()}"


def inside(points: NDArray[np.float64], border: NDArray[np.float64]) -> bool:
    """Whether points lie in a convex quadrilateral: always on the same side of its edges."""
    edges = np.roll(border, -1, axis=0) - border
    away = points[:, None, :] - border
    side = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]
    return bool(np.all(side >= 0) or np.all(side <= 0))


PLACES = [
    # name, turn and tilt, width, CFA, exposure [DN of white] and surround
    ("colorchecker-classic", (4.0, 0.05), 560, "RGGB", (12_000.0, 0.04)),
    ("colorchecker-classic", (112.0, 0.15), 430, "GRBG", (900.0, 0.03)),
    ("colorchecker-classic", (-15.0, 0.0), 230, "mono", (5_000.0, 0.04)),
    ("colorchecker-passport", (187.0, 0.2), 350, "BGGR", (6_000.0, 0.04)),
    ("colorchecker-passport", (271.0, 0.0), 500, "GBRG", (600.0, 0.05)),
    ("dynamic-range-36-grid", (-20.0, 0.1), 480, "BGGR", (9_000.0, OPAQUE)),
    ("dynamic-range-36-grid", (95.0, 0.0), 300, "mono", (700.0, 0.03)),
    ("dynamic-range-36-ring", (9.0, 0.1), 580, "GBRG", (10_000.0, OPAQUE)),
    ("dynamic-range-36-ring", (190.0, 0.0), 560, "RGGB", (800.0, 0.03)),
]


@pytest.mark.parametrize(("name", "pose", "width", "cfa", "light"), PLACES)
def test_finds_charts_in_a_scene(
    name: str, pose: tuple[float, float], width: float, cfa: str, light: tuple[float, float]
) -> None:
    definition = chart_named(name)
    (turn, tilt), (exposure, surround) = pose, light
    corners = turned_corners((570.0, 410.0), width=width, aspect=definition.aspect, turn=turn, tilt=tilt)
    located = found(picture(definition, corners, surround=surround, cfa=cfa, exposure=exposure), definition, cfa)
    assert_on_their_patches(located, definition, corners)
    assert located.orientation == round(turn / 90) % 4 * 90
    # Corners of the whole from middles of patches: within two pixels of the preview, which are four of the mosaic.
    np.testing.assert_allclose(located.corners, corners, atol=4.0)


@pytest.mark.parametrize(
    ("turn", "tilt", "surround", "exposure"), [(-4.0, 0.1, OPAQUE, 12_000.0), (183.0, 0.0, 1.0, 2_000.0)]
)
def test_finds_step_wedges(turn: float, tilt: float, surround: float, exposure: float) -> None:
    definition = chart_named("stouffer-t4110")
    corners = turned_corners((1180.0, 420.0), width=1900.0, aspect=9.0, turn=turn, tilt=tilt)
    mosaic = picture(definition, corners, shape=(840, 2400), surround=surround, exposure=exposure)
    # Steps that are darker than that cannot be told from an opaque mask.
    assert_on_their_patches(found(mosaic, definition), definition, corners, darkest=2.0)


def test_finds_a_chart_that_shows_its_back() -> None:
    definition = chart_named("dynamic-range-36-grid")
    first, second, third, fourth = turned_corners((600.0, 400.0), width=500.0, aspect=1.0, turn=8.0)
    corners = (second, first, fourth, third)
    located = found(picture(definition, corners, surround=OPAQUE), definition)
    assert_on_their_patches(located, definition, corners)


def test_finds_a_film_whose_densities_nobody_stated() -> None:
    # The nominal steps of 0.1 are taken to look for a film of 0.2486 a step; 5 of its patches can be seen well.
    definition = chart_named("dynamic-range-36-grid")
    film = chart_named("dynamic-range-36-grid")
    steep = tuple(10.0 ** -(0.133 + 0.2486 * step) for step in range(36))
    corners = turned_corners((600.0, 400.0), width=520.0, aspect=1.0, turn=3.0)
    rng = np.random.default_rng(3)
    scene = np.full((800, 1200, 3), 1e-6)
    for border, light in zip(true_corners_of_patches(film, corners, share=1.0), steep, strict=True):
        (left, top), (right, bottom) = border.min(axis=0).round(), border.max(axis=0).round()
        scene[int(top) : int(bottom), int(left) : int(right)] = light
    located = found(photograph(scene, rng, flare=1e-6, exposure=14_000.0), definition)
    assert_on_their_patches(located, definition, corners, darkest=1.3)


def real(name: str) -> Path:
    path = DATA / name
    if not path.exists():
        pytest.skip(f"the real frame is not at {path}")
    return path


def test_finds_the_colorchecker_of_a_real_frame() -> None:
    image = read_raw(real("colorchecker-550d/colorchart.dng"))
    definition = chart_named("colorchecker-passport")
    located = locate(image.mosaic, cfa="RGGB", black=2056.0, white=15_000.0, definition=definition)
    # Outer corners of the corner patches as read off a picture of the frame, to a few pixels of blur.
    corners = ((669.0, 583.0), (1300.0, 569.0), (1310.0, 968.0), (652.0, 978.0))
    np.testing.assert_allclose(located.corners, corners, atol=12.0)
    assert_on_their_patches(located, definition, corners)


def test_finds_a_small_colorchecker_in_a_room() -> None:
    path = real("headerless/Indoor1_2592x1536_8bit_GRBG.raw")
    mosaic = np.fromfile(path, dtype=np.uint8).reshape(1536, 2592).astype(np.uint16)
    definition = chart_named("colorchecker-classic")
    located = locate(mosaic, cfa="GRBG", black=0.0, white=255.0, definition=definition)
    corners = ((588.0, 1143.0), (1098.0, 1147.0), (1103.0, 1488.0), (600.0, 1465.0))
    np.testing.assert_allclose(located.corners, corners, atol=10.0)
    assert_on_their_patches(located, definition, corners)


def test_finds_an_over_exposed_film_through_a_lens_that_distorts() -> None:
    path = real("headerless/openisp_1920x1080_10bit.raw")
    mosaic = np.fromfile(path, dtype="<u2").reshape(1080, 1920)
    located = locate(mosaic, cfa="RGGB", black=0.0, white=1023.0, definition=chart_named("dynamic-range-36-ring"))
    assert located.reason == ""
    assert located.orientation == 180
    # Middles of patches as read off a picture of the frame; half of a patch is 62 pixels.
    read_off = {
        "1": (1122, 990),
        "5": (1242, 868),
        "14": (490, 755),
        "23": (1354, 355),
        "32": (600, 250),
        "33": (1098, 112),
    }
    middles = {one.name: (one.x + one.width / 2, one.y + one.height / 2) for one in located.patches}
    for name, place in read_off.items():
        np.testing.assert_allclose(middles[name], place, atol=15.0)
