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

from fullwell.frames.chart.definition import ChartDefinition, chart_named, chart_names
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


@pytest.fixture(scope="module")
def colorchecker() -> tuple[NDArray[np.uint16], Corners]:
    definition = chart_named("colorchecker-classic")
    corners = turned_corners((600.0, 400.0), width=500.0, aspect=definition.aspect, turn=-7.0, tilt=0.1)
    return picture(definition, corners), corners


@pytest.fixture(scope="module")
def grid() -> NDArray[np.uint16]:
    definition = chart_named("dynamic-range-36-grid")
    return picture(definition, turned_corners((600.0, 400.0), width=500.0, aspect=1.0, turn=5.0))


@pytest.mark.parametrize("name", [name for name in chart_names() if not name.startswith("colorchecker")])
def test_a_colorchecker_is_no_other_chart(name: str, colorchecker: tuple[NDArray[np.uint16], Corners]) -> None:
    located = found(colorchecker[0], chart_named(name))
    assert located.confidence < CONFIDENCE
    assert "--corners" in located.reason


@pytest.mark.parametrize("name", [name for name in chart_names() if not name.endswith("grid")])
def test_a_grid_is_no_other_chart(name: str, grid: NDArray[np.uint16]) -> None:
    located = found(grid, chart_named(name))
    assert located.confidence < CONFIDENCE
    assert "--patches" in located.reason


@pytest.mark.parametrize("name", chart_names())
@pytest.mark.parametrize("seed", [5, 6])
def test_a_scene_is_no_chart(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = textured_scene(rng, 600, 900)
    if seed == 6:
        # A wall of windows: a grid as regular as any chart's, its light at random.
        for row in range(5):
            for column in range(8):
                scene[40 + 90 * row : 110 + 90 * row, 60 + 90 * column : 130 + 90 * column] = rng.uniform(0.02, 0.9)
    located = found(photograph(scene, rng), chart_named(name))
    assert located.confidence < CONFIDENCE
    assert "was not found" in located.reason


@pytest.mark.parametrize("level", [0, int(BLACK), int(WHITE)])
def test_frames_without_anything_are_refused(level: int) -> None:
    mosaic = np.full((400, 600), level, dtype=np.uint16)
    located = found(mosaic, chart_named("colorchecker-classic"))
    assert located == Located(patches=(), confidence=0.0, corners=(), orientation=0, reason=located.reason)
    assert "nothing but noise" in located.reason


def test_a_dark_frame_is_refused() -> None:
    noise = np.random.default_rng(1).normal(BLACK, 5.0, size=(400, 600)).round().astype(np.uint16)
    assert "nothing but noise" in found(noise, chart_named("stouffer-t4110")).reason


def test_a_frame_smaller_than_a_preview_is_refused() -> None:
    located = found(np.full((10, 12), 900, dtype=np.uint16), chart_named("colorchecker-classic"))
    assert located.confidence == 0.0
    assert located.reason


@pytest.mark.parametrize("middle", [(1030.0, 400.0), (600.0, 690.0)])
def test_a_chart_that_leaves_the_frame_is_refused(middle: tuple[float, float]) -> None:
    definition = chart_named("colorchecker-classic")
    corners = turned_corners(middle, width=500.0, aspect=definition.aspect, turn=5.0)
    located = found(picture(definition, corners), definition)
    assert located.confidence < CONFIDENCE
    assert "patches of the X-Rite ColorChecker Classic lie in the frame" in located.reason


def test_a_chart_too_small_to_measure_is_refused() -> None:
    definition = chart_named("colorchecker-classic")
    corners = turned_corners((300.0, 200.0), width=88.0, aspect=definition.aspect)
    located = found(picture(definition, corners, shape=(400, 600), blur=0.5), definition)
    assert located.confidence < CONFIDENCE
    assert "too small" in located.reason


def test_over_exposed_steps_are_not_guessed() -> None:
    # Eight steps of the wedge are white and so is what lies around them: nobody can say where it begins.
    definition = chart_named("stouffer-t4110")
    corners = turned_corners((1180.0, 420.0), width=1900.0, aspect=9.0)
    mosaic = picture(definition, corners, shape=(840, 2400), surround=1.0, exposure=130_000.0)
    located = found(mosaic, definition)
    assert located.confidence < CONFIDENCE
    assert "--corners" in located.reason


def test_corners_of_the_user_are_taken_as_they_are(colorchecker: tuple[NDArray[np.uint16], Corners]) -> None:
    definition = chart_named("colorchecker-classic")
    mosaic, corners = colorchecker
    located = found(mosaic, definition, corners=corners)
    np.testing.assert_allclose(located.corners, corners, atol=1e-6)
    assert_on_their_patches(located, definition, corners)


def test_corners_of_a_turned_chart_are_refused(colorchecker: tuple[NDArray[np.uint16], Corners]) -> None:
    mosaic, corners = colorchecker
    located = found(mosaic, chart_named("colorchecker-classic"), corners=(*corners[2:], *corners[:2]))
    assert located.confidence < CONFIDENCE
    assert "check their order" in located.reason


@pytest.mark.parametrize(
    "corners",
    [
        ((700.0, 300.0), (1400.0, 300.0), (1400.0, 700.0), (700.0, 700.0)),
        ((100.0, 100.0), (500.0, 500.0), (500.0, 100.0), (100.0, 500.0)),
        ((100.0, 100.0), (300.0, 100.0), (500.0, 100.0), (700.0, 100.0)),
    ],
    ids=["outside", "crossed", "in line"],
)
def test_impossible_corners_are_refused(colorchecker: tuple[NDArray[np.uint16], Corners], corners: Corners) -> None:
    located = found(colorchecker[0], chart_named("colorchecker-classic"), corners=corners)
    assert located.confidence < CONFIDENCE
    assert located.reason


def test_finds_the_colorchecker_of_a_real_frame() -> None:
    path = DATA / "colorchecker-550d/colorchart.dng"
    if not path.exists():
        pytest.skip(f"the real frame is not at {path}")
    image = read_raw(path)
    definition = chart_named("colorchecker-passport")
    located = locate(image.mosaic, cfa="RGGB", black=2056.0, white=15_000.0, definition=definition)
    # Outer corners of the corner patches as read off a picture of the frame, to a few pixels of blur.
    corners = ((669.0, 583.0), (1300.0, 569.0), (1310.0, 968.0), (652.0, 978.0))
    np.testing.assert_allclose(located.corners, corners, atol=12.0)
    assert_on_their_patches(located, definition, corners)
