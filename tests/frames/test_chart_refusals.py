"""What is no chart, or not all of one, is refused with a sentence."""

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


def picture(
    definition: ChartDefinition,
    corners: Corners,
    *,
    shape: tuple[int, int] = (600, 900),
    surround: float = 0.04,
    **camera: float,
) -> NDArray[np.uint16]:
    rng = np.random.default_rng(1)
    scene = textured_scene(rng, *shape)
    draw_chart(scene, definition, corners, surround=surround)
    return photograph(scene, rng, **camera)


def found(mosaic: NDArray[np.uint16], definition: ChartDefinition, **options: Corners) -> Located:
    return locate(mosaic, cfa="RGGB", black=BLACK, white=WHITE, definition=definition, **options)


@pytest.fixture(scope="module")
def colorchecker() -> tuple[NDArray[np.uint16], Corners]:
    definition = chart_named("colorchecker-classic")
    corners = turned_corners((450.0, 300.0), width=400.0, aspect=definition.aspect, turn=-7.0, tilt=0.1)
    return picture(definition, corners), corners


@pytest.fixture(scope="module")
def grid() -> NDArray[np.uint16]:
    definition = chart_named("dynamic-range-36-grid")
    return picture(definition, turned_corners((450.0, 300.0), width=400.0, aspect=1.0, turn=5.0))


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


@pytest.mark.parametrize("middle", [(790.0, 300.0), (450.0, 520.0)])
def test_a_chart_that_leaves_the_frame_is_refused(middle: tuple[float, float]) -> None:
    definition = chart_named("colorchecker-classic")
    corners = turned_corners(middle, width=400.0, aspect=definition.aspect, turn=5.0)
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
    assert located.confidence >= CONFIDENCE
    assert located.reason == ""
    middles = np.array([(one.x + one.width / 2, one.y + one.height / 2) for one in located.patches])
    assert np.all(np.abs(middles - true_corners_of_patches(definition, corners, share=1.0).mean(axis=1)) < 2.0)


def test_corners_of_a_turned_chart_are_refused(colorchecker: tuple[NDArray[np.uint16], Corners]) -> None:
    mosaic, corners = colorchecker
    located = found(mosaic, chart_named("colorchecker-classic"), corners=(*corners[2:], *corners[:2]))
    assert located.confidence < CONFIDENCE
    assert "check their order" in located.reason


@pytest.mark.parametrize(
    "corners",
    [
        ((500.0, 300.0), (1100.0, 300.0), (1100.0, 700.0), (500.0, 700.0)),
        ((100.0, 100.0), (500.0, 500.0), (500.0, 100.0), (100.0, 500.0)),
        ((100.0, 100.0), (300.0, 100.0), (500.0, 100.0), (700.0, 100.0)),
    ],
    ids=["outside", "crossed", "in line"],
)
def test_impossible_corners_are_refused(colorchecker: tuple[NDArray[np.uint16], Corners], corners: Corners) -> None:
    located = found(colorchecker[0], chart_named("colorchecker-classic"), corners=corners)
    assert located.confidence < CONFIDENCE
    assert located.reason
