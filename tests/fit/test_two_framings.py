from itertools import combinations

import numpy as np
import pytest

from fullwell.fit.two_framings import two_framings

PRNU = 0.005477
TEXTURE = 0.008
SHIFT = 4
EDGE = 60


def _smooth(rng, shape, texture):
    """White texture, or one that neighbours share: a 3 x 3 mean of it, of the same variance."""
    fine = rng.standard_normal((shape[0] + 2, shape[1] + 2))
    if texture == "white":
        return fine[1:-1, 1:-1]
    return sum(fine[v : v + shape[0], u : u + shape[1]] for v in range(3) for u in range(3)) / 3.0


def _framings(rng, levels, *, texture="white", shift=SHIFT):
    """Two shots of the same sensor pixels, the chart's texture moved; signal above black [DN], K 0.5, 5.4 e- noise."""
    first, second = [], []
    for level in levels:
        sensor = 1.0 + PRNU * rng.standard_normal((EDGE, EDGE))
        chart = 1.0 + TEXTURE * _smooth(rng, (EDGE + shift, EDGE), texture)
        gradient = 1.0 + 0.02 * np.linspace(-0.5, 0.5, EDGE)
        for shots, view in ((first, chart[:EDGE]), (second, chart[shift:])):
            light = level * sensor * view * gradient
            noise = np.sqrt(0.5 * light + 2.7**2)
            shots.append(light + noise * rng.standard_normal(light.shape))
    return first, second


@pytest.mark.parametrize("texture", ["white", "smooth"])
def test_two_framings_see_the_sensor_through_the_texture(texture):
    """METHOD 1.9: a single framing reads PRNU and texture together; the covariance is PRNU alone and covers."""
    sets, levels = 300, (9000.0, 4000.0, 1500.0, 300.0)
    rng = np.random.default_rng(190)
    found = [two_framings(*_framings(rng, levels, texture=texture)) for _ in range(sets)]
    value = np.array([one.prnu_variance.value for one in found])
    error = np.array([one.prnu_variance.std_error for one in found])
    leak = 6.0 * TEXTURE**2 * (1.0 if texture == "white" else 9.0) / EDGE**2  # coarse texture common to both surfaces
    assert abs(value.mean() - (PRNU**2 - leak)) <= 4.0 * value.std() / np.sqrt(sets)
    assert abs(value.mean() - PRNU**2) <= 0.04 * PRNU**2
    assert 0.85 <= value.std() / error.mean() <= 1.1
    covered = np.mean([one.prnu_variance.ci95[0] <= PRNU**2 <= one.prnu_variance.ci95[1] for one in found])
    assert abs(covered - 0.955) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)
    single = np.sqrt(np.mean([one.first_variance for one in found]))
    assert single > np.hypot(PRNU, TEXTURE)
    assert np.mean([one.clean for one in found]) > 0.97
    assert found[0].n == len(levels) * EDGE**2


def test_pairs_of_several_framings_err_together():
    """Three and four framings of the same pixels, each with each: errors of independent pairs were a quarter short."""
    sets, edge = 300, 40
    rng = np.random.default_rng(192)
    for framings in (3, 4):
        pulls, apart = [], []
        for _ in range(sets):
            sensor = 1.0 + PRNU * rng.standard_normal((edge, edge))
            shots = [6000.0 * sensor + 50.0 * rng.standard_normal(sensor.shape) for _ in range(framings)]
            pairs = list(zip(*combinations(shots, 2), strict=True))
            for number, found in ((framings, pulls), (2, apart)):
                prnu = two_framings(*pairs, framings=number).prnu_variance
                found.append((prnu.value - PRNU**2) / prnu.std_error)
        assert abs(np.std(pulls) - 1.0) <= 4.0 / np.sqrt(2.0 * sets)
        assert np.std(apart) > 1.2


def test_a_shift_too_small_for_the_texture_is_noticed():
    """Texture smooth over 3 pixels, the chart moved by 1: covariance holds texture, and neighbours tell."""
    rng = np.random.default_rng(191)
    found = two_framings(*_framings(rng, (9000.0, 8000.0, 7000.0, 4000.0), texture="smooth", shift=1))
    assert not found.clean
    assert found.neighbour_covariance.value > 0.0
    assert found.prnu_variance.value > 1.5 * PRNU**2


def test_bright_regions_carry_the_weight():
    rng = np.random.default_rng(192)
    first, second = _framings(rng, (9000.0, 30.0))
    alone, both = two_framings(first[:1], second[:1]), two_framings(first, second)
    assert both.prnu_variance.value == pytest.approx(alone.prnu_variance.value, rel=0.05)
    assert both.prnu_variance.std_error == pytest.approx(alone.prnu_variance.std_error, rel=1e-3)


def test_regions_have_to_match():
    plane = np.full((20, 20), 100.0)
    with pytest.raises(ValueError, match="at least one region"):
        two_framings([], [])
    with pytest.raises(ValueError, match="same pixels"):
        two_framings([plane], [plane[1:]])
    with pytest.raises(ValueError, match="8 x 8"):
        two_framings([plane[:7]], [plane[:7]])
    with pytest.raises(ValueError, match="above black"):
        two_framings([plane], [-plane])
