"""Non-uniformity of maps that are simulated pixel by pixel: METHOD's T15 and T16."""

import numpy as np
import pytest

from fullwell.fit.noise_floor import noise_floor
from fullwell.fit.nonuniformity import dark_nonuniformity, nonuniformity
from fullwell.statistics.patch import patch_statistics
from fullwell.statistics.pattern import pattern
from fullwell.statistics.pixels import line_coefficients
from fullwell.units import DN2, ONE, Measured, square_root

SETS = 400
PRNU = 0.007
DSNU_DN = 0.4
SYSTEM_GAIN = 0.17
READ_DN = 1.5


def _temporal_variance_dn2(signal_dn):
    return SYSTEM_GAIN * signal_dn + READ_DN**2


def _bowl(rows, columns):
    v, u = np.mgrid[-1.0 : 1.0 : rows * 1j, -1.0 : 1.0 : columns * 1j]
    return 1.0 - 0.05 * (u**2 + v**2) + 0.02 * u


def _by_tile(per_pixel, tile):
    """Mean of each tile; the plane is a whole number of tiles."""
    rows, columns = per_pixel.shape
    return per_pixel.reshape(rows // tile, tile, columns // tile, tile).mean(axis=(1, 3))


def _covers(found, truth):
    low, high = found.ci95
    return low <= truth <= high


def _stack(rng, offset_dn, frames, *, light_dn=0.0):
    """Frames of a static scene; light alone has shot noise."""
    noise_dn = np.float32(np.sqrt(_temporal_variance_dn2(light_dn)))
    noise = rng.standard_normal((frames, *offset_dn.shape), np.float32)
    return (light_dn + offset_dn).astype(np.float32) + noise_dn * noise


@pytest.mark.parametrize("correlation", [0.0, 0.5])
def test_T15_stacks_give_prnu_and_dsnu(correlation, mean_squares_of):  # noqa: N802 - METHOD's name of the test
    """96 x 96 pixels, 16 flats of 800 DN and 16 darks; METHOD 5.1."""
    edge, frames, tile, signal_dn = 96, 16, 32, 800.0
    rng = np.random.default_rng(15)
    dof = np.full((2, edge // tile, edge // tile), tile**2 * (frames - 1.0))
    shading = _bowl(edge, edge)
    roots, covered, difference_of_variances = [], [], []
    for _ in range(SETS):
        response, other = rng.standard_normal((2, edge, edge))
        offset = DSNU_DN * (correlation * response + np.sqrt(1.0 - correlation**2) * other)
        flats = _stack(rng, offset, frames, light_dn=signal_dn * shading * (1.0 + PRNU * response))
        darks = _stack(rng, offset, frames)
        flat, dark = (stack.mean(axis=0, dtype=np.float64) for stack in (flats, darks))
        noise = np.stack([flats.var(axis=0, ddof=1), darks.var(axis=0, ddof=1)])
        floor = noise_floor([1.0, -1.0], [_by_tile(one, tile) for one in noise], dof, frames=[frames, frames])
        prnu = nonuniformity(pattern(flat - dark, tile=tile, relative=True), floor, unit=ONE).total
        dsnu = dark_nonuniformity(mean_squares_of(darks[np.newaxis])[0], darks.shape).total
        roots.append([square_root(prnu, ONE).value, square_root(dsnu, "DN").value])
        covered.append([_covers(prnu, PRNU**2), _covers(dsnu, DSNU_DN**2)])
        spatial = patch_statistics(flat).variance - patch_statistics(dark).variance
        temporal = float(noise[0].mean() - noise[1].mean()) / frames
        difference_of_variances.append((spatial - temporal) / flat.mean() ** 2)
    bias = np.mean(roots, axis=0) / [PRNU, DSNU_DN] - 1.0
    assert np.all(np.abs(bias) <= 0.003), bias
    coverage = np.mean(covered, axis=0)
    assert np.all((coverage >= 0.92) & (coverage <= 0.98)), coverage
    published = np.array(difference_of_variances) / PRNU**2 - 1.0
    expected = 2.0 * correlation * DSNU_DN / (signal_dn * PRNU)  # +7.1 % at 0.5
    assert abs(published.mean() - expected) <= 4.0 * published.std(ddof=1) / np.sqrt(SETS), published.mean()


def _slope_maps(rng, exposures_s, frames, *, slope_dn_per_s, edge):
    """Burst means of one plane and their temporal variances per pixel, shapes (exposures, edge, edge)."""
    response = 1.0 + PRNU * rng.standard_normal((edge, edge))
    level = exposures_s[:, None, None] * slope_dn_per_s * _bowl(edge, edge) * response
    variance = _temporal_variance_dn2(level)
    offset = 64.0 + DSNU_DN * rng.standard_normal((edge, edge))
    means = level + offset + np.sqrt(variance / frames) * rng.standard_normal(level.shape)
    return means, variance * rng.chisquare(frames - 1, level.shape) / (frames - 1)


@pytest.mark.parametrize("weighted", [False, True])
def test_T16_slopes_give_prnu(weighted):  # noqa: N802 - METHOD's name of the test
    """64 x 64 pixels, five exposures of five frames, up to 400 DN; METHOD 5.2. Averaged greens lose 1 - 1 / sqrt 2."""
    edge, frames, exposures_s = 64, 5, np.array([0.01, 0.02, 0.04, 0.08, 0.16])
    rng = np.random.default_rng(16)
    dof = np.full((exposures_s.size, 1, 1), edge**2 * (frames - 1.0))
    roots, covered, factors = [], [], []
    for _ in range(SETS):
        slopes = []
        for _ in range(2):
            means, variances = _slope_maps(rng, exposures_s, frames, slope_dn_per_s=2500.0, edge=edge)
            noise = variances.mean(axis=(1, 2), keepdims=True)
            weights = frames / noise.ravel() if weighted else None
            combination = line_coefficients(exposures_s.tolist(), weights)[0]
            slopes.append(np.tensordot(combination, means, axes=1))
            floor = noise_floor(combination, noise, dof, frames=np.full(exposures_s.size, frames))
            prnu = nonuniformity(pattern(slopes[-1], tile=edge, relative=True), floor, unit=ONE).total
            roots.append(square_root(prnu, ONE).value)
            covered.append(_covers(prnu, PRNU**2))
        both = [pattern(one, tile=edge, relative=True).variance.item() for one in (*slopes, np.mean(slopes, axis=0))]
        factors.append(np.sqrt(both[2] / np.mean(both[:2])))
    assert abs(np.mean(roots) / PRNU - 1.0) <= 0.008, np.mean(roots) / PRNU
    assert 0.03 <= np.std(roots) / PRNU <= 0.05  # METHOD 5.2: 4.0 and 3.6 %
    assert 0.92 <= np.mean(covered) <= 0.98, np.mean(covered)
    assert abs(np.mean(factors) - np.sqrt(0.5)) <= 0.005


def test_intercepts_give_dsnu_with_a_larger_error():
    """The same series as T16: unbiased, but the noise floor x times the DSNU^2 widens the scatter by 1 + x."""
    edge, frames, exposures_s = 64, 5, np.array([0.01, 0.02, 0.04, 0.08, 0.16])
    rng = np.random.default_rng(17)
    dof = np.full((exposures_s.size, 1, 1), edge**2 * (frames - 1.0))
    found = []
    for _ in range(SETS // 2):
        means, variances = _slope_maps(rng, exposures_s, frames, slope_dn_per_s=2500.0, edge=edge)
        noise = variances.mean(axis=(1, 2), keepdims=True)
        combination = line_coefficients(exposures_s.tolist(), frames / noise.ravel())[1]
        floor = noise_floor(combination, noise, dof, frames=np.full(exposures_s.size, frames))
        map_dn = np.tensordot(combination, means, axes=1)
        found.append(nonuniformity(pattern(map_dn, tile=edge, relative=False), floor, unit=DN2).total)
    values = np.array([one.value for one in found])
    assert abs(values.mean() - DSNU_DN**2) <= 4.0 * values.std(ddof=1) / np.sqrt(values.size)
    covered = np.mean([_covers(one, DSNU_DN**2) for one in found])
    assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / values.size), covered
    excess = floor.variance.item() / DSNU_DN**2
    expected = np.sqrt(2.0 / edge**2 * (1.0 + excess) ** 2 + 2.0 / (edge**2 * (frames - 1)) * excess**2)
    assert abs(values.std(ddof=1) / DSNU_DN**2 / expected - 1.0) <= 4.0 / np.sqrt(2 * values.size)
    assert excess > 2.0


def test_noise_floor_is_that_of_the_combination():
    rng = np.random.default_rng(18)
    combination, frames = np.array([0.5, -2.0, 1.5]), np.array([4, 9, 16])
    variances = np.array([1.0, 2.0, 3.0])
    means = np.sqrt(variances / frames) * rng.standard_normal((100_000, 3))
    floor = noise_floor(
        combination,
        variances[:, None, None] * np.ones((3, 2, 2)),
        np.full((3, 2, 2), 50.0),
        frames=frames,
        row_variances=[Measured.normal(value, 0.01, "DN^2") for value in (0.1, 0.2, 0.0)],
        column_variances=[Measured.normal(value, 0.02, "DN^2") for value in (0.0, 0.0, 0.5)],
    )
    expected = (means @ combination).var(ddof=1)
    assert floor.variance.shape == floor.dof.shape == (2, 2)
    assert abs(floor.variance[0, 0] / expected - 1.0) <= 4.0 * np.sqrt(2.0 / 100_000)
    parts = combination**2 * variances / frames
    assert floor.dof[1, 1] == pytest.approx(50.0 * parts.sum() ** 2 / np.sum(parts**2))
    assert floor.row == pytest.approx(0.25 * 0.1 / 4 + 4.0 * 0.2 / 9)
    assert floor.column == pytest.approx(2.25 * 0.5 / 16)
    assert floor.row_error == pytest.approx(0.01 * np.linalg.norm(combination**2 / frames))
    assert floor.column_error == pytest.approx(0.02 * np.linalg.norm(combination**2 / frames))
