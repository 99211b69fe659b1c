"""A mosaic becomes a picture that keeps what was measured and shows it as it was seen."""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageOps

from fullwell.raw.cfa import BAYER, MONO
from fullwell.render.demosaic import demosaic
from fullwell.render.picture import STYLES, developed, picture, reduced, upright, write_png
from fullwell.render.tone import grey_world, relative, srgb_curve, white_balanced

EPSILON = float(np.finfo(np.float32).eps)


def sampled(rgb: np.ndarray, cfa: str) -> np.ndarray:
    """Return what a mosaic sees of a picture."""
    if cfa == MONO:
        return rgb[:, :, 1].copy()
    out = np.empty(rgb.shape[:2], dtype=np.float32)
    for site, letter in enumerate(cfa):
        window = (slice(site // 2, None, 2), slice(site % 2, None, 2))
        out[window] = rgb[(*window, "RGB".index(letter))]
    return out


def kernel(taps: dict[tuple[int, int], float]) -> np.ndarray:
    """Return a symmetric 5 x 5 kernel from its weights at one of the equivalent places, in eighths."""
    out = np.zeros((5, 5))
    for (down, across), weight in taps.items():
        for vertical in {down, -down}:
            for horizontal in {across, -across}:
                out[2 + vertical, 2 + horizontal] = weight / 8.0
    return out


GREEN = kernel({(0, 0): 4, (0, 1): 2, (1, 0): 2, (0, 2): -1, (2, 0): -1})
BESIDE = kernel({(0, 0): 5, (0, 1): 4, (1, 1): -1, (0, 2): -1, (2, 0): 0.5})
CORNERS = kernel({(0, 0): 6, (1, 1): 2, (0, 2): -1.5, (2, 0): -1.5})


@pytest.mark.parametrize("cfa", BAYER)
def test_demosaicking_is_the_published_kernels(cfa: str) -> None:
    """Figure 2 of Malvar, He and Cutler, applied pixel by pixel."""
    mosaic = np.random.default_rng(4).uniform(0.0, 1.0, (12, 14)).astype(np.float32)
    found = demosaic(mosaic, cfa=cfa)
    for row in range(2, 10):
        for column in range(2, 12):
            around = mosaic[row - 2 : row + 3, column - 2 : column + 3].astype(np.float64)
            own = cfa[row % 2 * 2 + column % 2]
            beside = cfa[row % 2 * 2 + (column + 1) % 2]
            below = cfa[(row + 1) % 2 * 2 + column % 2]
            truth = {own: mosaic[row, column]}
            if own == "G":
                truth |= {beside: (around * BESIDE).sum(), below: (around * BESIDE.T).sum()}
            else:
                truth |= {"G": (around * GREEN).sum(), "RB".replace(own, ""): (around * CORNERS).sum()}
            # The sum of the absolute weights is below 4, each of some twenty operations rounds once.
            np.testing.assert_allclose(
                found[row, column], [truth[letter] for letter in "RGB"], rtol=0, atol=80 * EPSILON
            )


@given(
    cfa=st.sampled_from([*BAYER, MONO]),
    height=st.integers(4, 11),
    width=st.integers(4, 11),
    slope=st.tuples(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01)),
)
def test_a_grey_ramp_stays_a_grey_ramp(cfa: str, height: int, width: int, slope: tuple[float, float]) -> None:
    """All kernels keep linear surfaces; the edges reflect, so that it holds inside."""
    ramp = 0.5 + slope[0] * np.arange(height)[:, None] + slope[1] * np.arange(width)[None, :]
    grey = np.repeat(ramp.astype(np.float32)[:, :, None], 3, axis=2)
    found = demosaic(sampled(grey, cfa), cfa=cfa)
    np.testing.assert_allclose(found[2:-2, 2:-2], grey[2:-2, 2:-2], rtol=0, atol=80 * EPSILON)


@pytest.mark.parametrize("cfa", [*BAYER, MONO])
def test_even_colour_is_exact_to_the_edges_and_measured_pixels_stay(cfa: str) -> None:
    colour = np.full((7, 9, 3), (0.5, 0.25, 0.125), dtype=np.float32)
    expected = colour if cfa != MONO else np.full_like(colour, 0.25)
    np.testing.assert_allclose(demosaic(sampled(colour, cfa), cfa=cfa), expected, rtol=0, atol=80 * EPSILON)
    mosaic = np.random.default_rng(1).normal(0.3, 0.5, (7, 9)).astype(np.float32)
    np.testing.assert_array_equal(sampled(demosaic(mosaic, cfa=cfa), cfa), mosaic)


def test_levels_run_from_black_to_white_by_site_and_beyond() -> None:
    mosaic = np.array([[64, 1023], [60, 64 + 480]], dtype=np.uint16)
    light = relative(mosaic, cfa="RGGB", black_level=(64, 63, 64, 64), white_level=(1024, 1023, 1024, 1024))
    np.testing.assert_allclose(light, [[0.0, 1.0], [-4 / 960, 0.5]], rtol=0, atol=EPSILON)


def test_a_grey_world_becomes_grey_whatever_the_light() -> None:
    texture = np.random.default_rng(8).uniform(0.1, 0.9, (40, 60, 1))
    seen = (texture * np.array([0.52, 1.0, 0.61])).astype(np.float32)
    seen[:6, :6] = 1.0  # clipped highlights say nothing of the light
    neutral = grey_world(sampled(seen, "BGGR"), cfa="BGGR")
    balanced = white_balanced(seen[6:, 6:], neutral=neutral)
    # Each plane holds 600 values of standard deviation 0.8/sqrt(12) about 0.5; a ratio of two means has twice that.
    bound = 4.0 * np.sqrt(2.0) * 0.8 / np.sqrt(12.0) / 0.5 / np.sqrt(564.0)
    np.testing.assert_allclose(balanced[..., 0] / balanced[..., 1], 1.0, rtol=0, atol=bound)
    np.testing.assert_allclose(balanced[..., 2] / balanced[..., 1], 1.0, rtol=0, atol=bound)
    assert (white_balanced(seen, neutral=neutral) >= seen).all()
    assert grey_world(np.zeros((4, 4), dtype=np.float32), cfa="RGGB") == (1.0, 1.0, 1.0)
    assert grey_world(np.ones((4, 4), dtype=np.float32), cfa=MONO) == (1.0, 1.0, 1.0)


def test_the_curve_is_srgb() -> None:
    """Codes 0 to 255 of sRGB, made linear by the inverse in IEC 61966-2-1, come back."""
    codes = np.arange(256)
    shown = codes / 255.0
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    found = srgb_curve(light.astype(np.float32))
    np.testing.assert_allclose(found, shown, rtol=0, atol=8 * EPSILON)
    assert np.rint(255.0 * found).astype(int).tolist() == codes.tolist()


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_picture_stands_upright_as_pillow_has_it(orientation: int) -> None:
    stored = np.random.default_rng(9).integers(0, 256, (3, 5, 3), dtype=np.uint8)
    image, file = Image.fromarray(stored), io.BytesIO()
    exif = Image.Exif()
    exif[274] = orientation
    image.save(file, format="PNG", exif=exif)
    theirs = np.asarray(ImageOps.exif_transpose(Image.open(file)))
    np.testing.assert_array_equal(upright(stored.astype(np.float32), orientation), theirs.astype(np.float32))


def test_a_large_picture_shrinks_to_the_means_of_squares() -> None:
    rgb = np.random.default_rng(2).uniform(0.0, 1.0, (7, 13, 3)).astype(np.float32)
    small = reduced(rgb, longest=5)
    assert small.shape == (2, 4, 3)
    np.testing.assert_allclose(small[1, 2], rgb[3:6, 6:9].mean(axis=(0, 1)), rtol=4 * EPSILON)
    assert reduced(rgb, longest=13) is rgb
    assert reduced(rgb[:1], longest=4).shape == (1, 3, 3)


@pytest.mark.parametrize("style", STYLES)
def test_a_picture_reaches_its_file(tmp_path: Path, style: str) -> None:
    light = np.full((6, 8), 0.18, dtype=np.float32)
    light[1::2, 1::2] = 0.09  # a blue pixel sees half of it
    shown = picture(developed(light, cfa="RGGB"), style=style, neutral=(1.0, 1.0, 0.5), orientation=6)
    path = tmp_path / "picture.png"
    write_png(path, shown)
    with Image.open(path) as opened:
        assert (opened.size, opened.mode) == ((6, 8), "RGB")
        middle = opened.getpixel((3, 4))
    grey, half = round(255 * 0.461356), round(255 * 0.331799)
    assert middle == ((grey, grey, grey) if style == "srgb" else (grey, grey, half))
