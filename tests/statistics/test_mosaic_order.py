"""The colour filters that a mosaic's content tells: right, or untold; never wrong."""

from itertools import product

import numpy as np
import pytest

from fullwell.raw.cfa import BAYER
from fullwell.simulate.scene import SUBJECTS
from fullwell.statistics.mosaic_order import Order, alternation, mosaic_order

LETTERS = {"R": 0, "G": 1, "B": 2}
RESPONSE = {"R": 0.5, "G": 1.0, "B": 0.6}
BLACK = 64.0


def mosaic(
    subject: str,
    cfa: str,
    rng: np.random.Generator,
    *,
    electrons: float = 2000.0,
    response: dict[str, float] = RESPONSE,
    sites: int = 2,
) -> np.ndarray:
    """Return a picture of a subject: photon noise, read noise, codes of 12 bits."""
    y, x = ((np.arange(side)[:, None] + 0.5) / side for side in (384, 512))
    light = np.empty((384, 512))
    for row, column in product(range(sites), repeat=2):
        letter = cfa[row * sites + column]
        part = (slice(row, None, sites), slice(column, None, sites))
        light[part] = response[letter] * SUBJECTS[subject](x.T[:, column::sites], y[row::sites, :], LETTERS[letter])
    signal = 0.5 * rng.poisson(electrons * light) + rng.normal(BLACK, 1.5, light.shape)
    return np.clip(np.round(signal), 0, 1023).astype(np.uint16)


@pytest.mark.parametrize("subject", sorted(SUBJECTS))
def test_orders_are_right_or_untold(subject: str) -> None:
    told = 0
    for seed, cfa in product(range(3), BAYER):
        found = mosaic_order(mosaic(subject, cfa, np.random.default_rng(seed)), black_dn=BLACK)
        assert found.order is Order.UNTOLD or cfa in found.order.names
        told += found.order is not Order.UNTOLD
    assert told >= 10 or subject in {"night", "star", "gradient", "flat"}


def test_nothing_is_told_of_darks_whatever_the_black_level_is_said_to_be() -> None:
    for seed in range(40):
        rng = np.random.default_rng(seed)
        dark = np.round(rng.normal(64.0, rng.uniform(0.5, 20.0), (384, 512)).clip(0)).astype(np.uint16)
        for black in (None, 0.0 if seed % 2 else 64.0):
            assert mosaic_order(dark, black_dn=black).order is Order.UNTOLD


def test_flats_whose_red_and_blue_are_alike_say_nothing_wrong() -> None:
    for seed, cfa in product(range(5), BAYER):
        rng = np.random.default_rng(seed)
        alike = {"R": rng.uniform(0.5, 0.6), "G": 1.0, "B": rng.uniform(0.5, 0.6)}
        found = mosaic_order(mosaic("flat", cfa, rng, response=alike), black_dn=BLACK)
        assert found.order is Order.UNTOLD or cfa in found.order.names


def test_greens_that_differ_by_some_per_cent_do_not_mislead() -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        frame = mosaic("flat", "RGGB", rng, response={"R": 0.7, "G": 1.0, "B": 0.7})
        frame[1::2, ::2] = np.round(frame[1::2, ::2] * 0.95)
        assert mosaic_order(frame, black_dn=None).order in {Order.UNTOLD, Order.GREENS_ANTI}


def test_a_monochrome_scene_is_alike_and_a_flat_field_untold() -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        grey = {"R": 1.0, "G": 1.0, "B": 1.0}
        assert mosaic_order(mosaic("gradient", "RGGB", rng, response=grey), black_dn=BLACK).order is Order.ALIKE
        assert mosaic_order(mosaic("flat", "RGGB", rng, response=grey), black_dn=BLACK).order is Order.UNTOLD


def test_two_by_two_alike_is_quad_bayer() -> None:
    quad = mosaic("sunset", "RRGGRRGGGGBBGGBB", np.random.default_rng(1), sites=4)
    assert mosaic_order(quad, black_dn=BLACK).order is Order.QUAD


def test_lines_that_take_turns() -> None:
    errors = []
    for seed in range(200):
        plane = np.random.default_rng(seed).normal(500.0, 3.0, (96, 128))
        plane += np.linspace(0.0, 50.0, 96)[:, None]
        found = alternation(plane.astype(np.float64).round().astype(np.uint16), axis=0)
        errors.append(found.difference_dn / found.std_error_dn)
    # 200 values of about standard normal size, a slope beneath them: the rms lies within 4 sigma of 1, 4 / sqrt(400)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.2)
