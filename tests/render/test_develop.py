"""A frame is developed into the scene that it saw: better than bilinear, with its colours and its greys."""

import numpy as np
import pytest

from fullwell.raw.cfa import BAYER, MONO, channels
from fullwell.render.demosaic import demosaic
from fullwell.render.develop import develop
from fullwell.render.directional import demosaic_along_edges
from fullwell.render.tone import srgb_curve
from fullwell.simulate.scene import SUBJECTS

SIZE = 192


def scene(subject: str) -> np.ndarray:
    """Return the light of a subject, four samples a pixel and direction averaged, shape (SIZE, SIZE, 3)."""
    places = (np.arange(4 * SIZE) + 0.5) / (4 * SIZE)
    fine = np.stack([SUBJECTS[subject](places[None, :], places[:, None], colour) for colour in range(3)], axis=-1)
    fine = np.clip(fine, 0.0, 1.0) * np.ones((4 * SIZE, 4 * SIZE, 1))
    return fine.reshape(SIZE, 4, SIZE, 4, 3).mean(axis=(1, 3)).astype(np.float32)


def sampled(rgb: np.ndarray, cfa: str) -> np.ndarray:
    out = np.empty(rgb.shape[:2], dtype=np.float32)
    for site, letter in enumerate(cfa):
        out[site // 2 :: 2, site % 2 :: 2] = rgb[site // 2 :: 2, site % 2 :: 2, "RGB".index(letter)]
    return out


def bilinear(mosaic: np.ndarray, cfa: str) -> np.ndarray:
    """Return the mean of the nearest neighbours of each colour."""
    out = np.empty((*mosaic.shape, 3))
    for colour, letter in enumerate("RGB"):
        mask = np.zeros(mosaic.shape)
        for site, name in enumerate(cfa):
            mask[site // 2 :: 2, site % 2 :: 2] = name == letter
        weights = np.array([[1.0, 2.0, 1.0], [2.0, 4.0, 2.0], [1.0, 2.0, 1.0]])
        total, count = np.zeros(mosaic.shape), np.zeros(mosaic.shape)
        padded, marks = np.pad(mosaic * mask, 1, mode="reflect"), np.pad(mask, 1, mode="reflect")
        for down in range(3):
            for across in range(3):
                window = np.s_[down : down + mosaic.shape[0], across : across + mosaic.shape[1]]
                total += weights[down, across] * padded[window]
                count += weights[down, across] * marks[window]
        out[..., colour] = np.where(mask > 0.0, mosaic, total / count)
    return out


def psnr(found: np.ndarray, truth: np.ndarray) -> float:
    inner = np.s_[4:-4, 4:-4]
    return float(-10.0 * np.log10(np.mean((found[inner] - truth[inner]) ** 2)))


@pytest.mark.parametrize("cfa", BAYER)
def test_edges_come_out_better_than_by_filters_that_know_of_none(cfa: str) -> None:
    for subject, over_bilinear, over_linear in (("star", 3.0, 1.0), ("window", 3.0, 0.5)):
        truth = scene(subject)
        mosaic = sampled(truth, cfa)
        found = psnr(demosaic_along_edges(mosaic, cfa=cfa), truth)
        assert found > psnr(bilinear(mosaic, cfa), truth) + over_bilinear
        assert found > psnr(demosaic(mosaic, cfa=cfa), truth) + over_linear


@pytest.mark.parametrize("cfa", BAYER)
def test_what_was_measured_is_kept_and_greys_stay_grey(cfa: str) -> None:
    mosaic = np.random.default_rng(1).uniform(0.0, 1.0, (30, 42)).astype(np.float32)
    assert np.array_equal(sampled(demosaic_along_edges(mosaic, cfa=cfa), cfa), mosaic)
    y, x = np.mgrid[:30, :42]
    ramp = (0.1 + 0.01 * x + 0.005 * y).astype(np.float32)
    found = demosaic_along_edges(ramp, cfa=cfa)[4:-4, 4:-4]
    assert np.abs(found - ramp[4:-4, 4:-4, None]).max() < 1e-6


def test_a_frame_is_developed_into_the_colours_of_its_scene() -> None:
    """Levels, white balance and colour matrix of a camera that mixes colours are undone."""
    cfa = "BGGR"
    truth = np.clip(scene("patches"), 0.0, 0.7)
    mix = np.array([[0.8, 0.2, 0.0], [0.1, 0.8, 0.1], [0.0, 0.3, 0.7]])
    response = {"R": 0.5, "G1": 1.0, "G2": 1.0, "B": 0.6}
    seen = truth @ mix.T.astype(np.float32)
    mosaic = sampled(seen, cfa)
    black = (100.0, 110.0, 120.0, 130.0)
    for site, channel in enumerate(channels(cfa)):
        window = np.s_[site // 2 :: 2, site % 2 :: 2]
        mosaic[window] = black[site] + (4000.0 - black[site]) * response[channel] * mosaic[window]
    shown = develop(
        np.rint(mosaic).astype(np.uint16),
        cfa=cfa,
        black_level=black,
        white_level=(4000.0,) * 4,
        neutral=(0.5, 1.0, 0.6),
        colour_matrix=np.linalg.inv(mix),
    )
    inside = np.zeros((SIZE, SIZE), dtype=bool)
    for row in range(4):
        for column in range(6):
            inside[48 * row + 14 : 48 * row + 34, 32 * column + 10 : 32 * column + 22] = True
    # rounding of 1/7800 of white, spread by the inverse of the mixture and steepest in the darkest greys
    assert np.abs(shown - srgb_curve(truth))[inside].max() < 12.92 * 3.0 / 7800.0 + 1e-3
    assert np.array_equal(
        develop(np.full((8, 8), 2050, np.uint16), cfa=MONO, black_level=(100.0,), white_level=(4000.0,)),
        np.full((8, 8, 3), srgb_curve(np.array([0.5], dtype=np.float32))[0]),
    )
