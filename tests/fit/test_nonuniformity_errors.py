"""Do the intervals of a signed variance hold what they say: rows, hot pixels, strong shading, nothing at all."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import chi2, norm
from scipy.stats import t as student

from fullwell.fit.noise_floor import NoiseFloor
from fullwell.fit.nonuniformity import nonuniformity
from fullwell.statistics.pattern import pattern
from fullwell.units import DN2, ONE, square_root

SETS = 400
REPEATS = 200
FLOOR_DOF_PER_PIXEL = 20
PARTS = ("total", "row", "column", "pixel")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A map of 1000 (any unit) at its centre, its standard deviations relative to that."""

    shape: tuple[int, int] = (64, 64)
    tile: int = 16
    pixel: float = 0.01
    row: float = 0.0
    column: float = 0.0
    hot_share: float = 0.0
    hot: float = 0.1
    noise: float = 0.005
    row_noise: float = 0.0
    falloff: float = 0.0

    @property
    def truth(self):
        pixel = self.pixel**2 + self.hot_share * self.hot**2
        return {
            "total": self.row**2 + self.column**2 + pixel,
            "row": self.row**2,
            "column": self.column**2,
            "pixel": pixel,
        }

    @property
    def tiles(self):
        """Those of 8 pixels or more on a side, which count."""
        return int(np.prod([side // self.tile + (side % self.tile >= 8) for side in self.shape]))

    @property
    def surface(self):
        v, u = (np.linspace(-1.0, 1.0, side) for side in self.shape)
        return 1000.0 * (1.0 - 0.5 * self.falloff * np.add.outer(v**2, u**2))

    def pattern(self, rng):
        rows, columns = self.shape
        normal = rng.standard_normal
        eps = self.row * normal((rows, 1)) + self.column * normal((1, columns)) + self.pixel * normal(self.shape)
        if self.hot_share:
            eps += self.hot * rng.choice([-1.0, 1.0], self.shape) * (rng.random(self.shape) < self.hot_share)
        return eps

    def measure(self, rng, eps):
        """Add shot noise, measure the floor by its own chi-square, and ask for the non-uniformity."""
        white = self.noise**2 * 1000.0 * self.surface
        lines = 1000.0 * self.row_noise * rng.standard_normal((self.shape[0], 1))
        found = pattern(
            self.surface * (1.0 + eps) + np.sqrt(white) * rng.standard_normal(self.shape) + lines,
            tile=self.tile,
            relative=True,
        )
        starts = [np.arange(0, side, self.tile) for side in self.shape]
        row = (1000.0 * self.row_noise) ** 2
        variance = np.add.reduceat(np.add.reduceat(white, starts[0], axis=0), starts[1], axis=1) / found.n + row
        dof = found.n * float(FLOOR_DOF_PER_PIXEL)
        floor = NoiseFloor(variance=variance * rng.chisquare(dof) / dof, dof=dof, row=row)
        return nonuniformity(found, floor, unit=ONE)


def _expected_coverage(tiles):
    """Of an interval whose squared error is multiplied by the tiles' scatter, where that is above 1 (sure: Student)."""
    if tiles == 1:
        return 0.95
    scatter = chi2.ppf((np.arange(20_000) + 0.5) / 20_000, tiles - 1) / (tiles - 1)
    sure = scatter > chi2.isf(0.01, tiles - 1) / (tiles - 1)
    reach = np.where(sure, student.ppf(0.975, tiles - 1), norm.ppf(0.975)) * np.sqrt(np.maximum(scatter, 1.0))
    return float(np.mean(2.0 * norm.cdf(reach) - 1.0))


def _window(expected):
    return 4.0 * np.sqrt(expected * (1.0 - expected) / SETS)


def _measured(case, seed, sets=SETS):
    rng = np.random.default_rng(seed)
    return [case.measure(rng, case.pattern(rng)) for _ in range(sets)]


def _coverage(found, name, truth):
    intervals = np.array([getattr(one, name).ci95 for one in found])
    return float(np.mean((intervals[:, 0] <= truth) & (truth <= intervals[:, 1])))


CASES = {
    "white": Case(),
    "one tile": Case(tile=64),
    "two tiles": Case(shape=(32, 64), tile=32),
    "tiles cut off": Case(shape=(75, 43)),
    "small tiles, noisy": Case(tile=8, noise=0.02),
    "rows": Case(row=0.005),
    "rows, columns, noise": Case(row=0.005, column=0.003, noise=0.02),
    "row noise": Case(row_noise=0.003),
    "nothing": Case(pixel=0.0),
    "strong shading": Case(shape=(96, 96), tile=16, falloff=0.7, noise=0.01),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_intervals_cover_and_values_are_unbiased(case):
    found = _measured(case, 61)
    expected = _expected_coverage(case.tiles)
    for name in PARTS:
        truth = case.truth[name]
        values = np.array([getattr(one, name).value for one in found])
        assert abs(values.mean() - truth) <= 4.0 * values.std(ddof=1) / np.sqrt(SETS), name
        aim = expected if name in ("total", "pixel") else 0.95
        covered = _coverage(found, name, truth)
        assert aim - _window(aim) <= covered <= max(aim, expected) + _window(aim), (name, covered, aim)
    if case.tiles > 1:
        size = np.mean([one.misfit for one in found])
        assert size <= 0.01 + 4.0 * np.sqrt(0.01 * 0.99 / SETS), size


@pytest.mark.parametrize("case", [CASES["rows, columns, noise"], CASES["strong shading"]], ids=["rows", "shading"])
def test_parts_add_up(case):
    for one in _measured(case, 62, sets=10):
        parts = one.row.value + one.column.value + one.pixel.value
        assert parts == pytest.approx(one.total.value, rel=1e-9)


@pytest.mark.parametrize("tile", [16, 32])
def test_hot_pixels_show_between_tiles(tile):
    """A tenth of a percent of pixels ten standard deviations off: chi-square alone would cover far less."""
    case = Case(shape=(128, 128), hot_share=0.001, tile=tile)
    found = _measured(case, 63)
    values = np.array([one.total.value for one in found])
    truth = case.truth["total"]
    assert abs(values.mean() - truth) <= 4.0 * values.std(ddof=1) / np.sqrt(SETS)
    covered = _coverage(found, "total", truth)
    assert 0.95 - _window(0.95) <= covered <= _expected_coverage(case.tiles) + _window(0.95), covered
    normal = norm.ppf(0.975) * truth * np.sqrt(2.0 / np.prod(case.shape))
    assert np.mean(np.abs(values - truth) <= normal) < 0.85
    assert np.mean([one.misfit for one in found]) > 0.5


def test_nothing_gives_an_upper_limit_above_zero():
    """METHOD 1.7: half of the signed variances lie below zero; their roots are 0 and keep an interval."""
    found = _measured(CASES["nothing"], 64)
    below = [one.total for one in found if one.total.value <= 0.0]
    assert abs(len(below) / SETS - 0.5) <= 4.0 * np.sqrt(0.25 / SETS)
    for total in below:
        root = square_root(replace(total, ci95=(total.ci95[0], max(total.ci95[1], 0.0))), ONE)
        assert root.value == 0.0
        assert root.std_error is None
        assert root.ci95[0] == 0.0
    limits = [one.total.ci95[1] for one in found]
    assert np.mean(np.array(limits) > 0.0) >= 0.975 - 4.0 * np.sqrt(0.975 * 0.025 / SETS)


REPEATED = {
    "noise only": Case(pixel=0.0),
    "white": Case(noise=0.01),
    "rows": Case(row=0.005, noise=0.01),
    "hot pixels": Case(hot_share=0.001, noise=0.01),
    "row noise": Case(row=0.005, row_noise=0.005),
    "strong shading": Case(shape=(96, 96), tile=16, falloff=0.7, noise=0.01),
}


@pytest.mark.parametrize("case", REPEATED.values(), ids=REPEATED)
def test_a_repeat_scatters_by_the_repeat_error(case):
    """The pattern stays, the noise is new; the difference of two such measurements is pulled by both errors."""
    rng = np.random.default_rng(65)
    pulls = []
    for _ in range(REPEATS):
        eps = case.pattern(rng)
        first, second = case.measure(rng, eps), case.measure(rng, eps)
        pulls.append((first.total.value - second.total.value) / np.hypot(first.repeat_error, second.repeat_error))
    assert abs(np.mean(pulls)) <= 4.0 / np.sqrt(REPEATS)
    assert abs(np.std(pulls) - 1.0) <= 4.0 / np.sqrt(2 * REPEATS), np.std(pulls)


def test_an_even_map_without_noise_has_no_pattern_and_no_error():
    found = pattern(np.full((32, 32), 500.0), tile=16, relative=True)
    one = nonuniformity(found, NoiseFloor(variance=np.zeros((2, 2)), dof=np.inf), unit=ONE)
    for name in PARTS:
        measured = getattr(one, name)
        assert (measured.value, measured.std_error, *measured.ci95) == pytest.approx((0.0,) * 4, abs=1e-60), name
    assert one.repeat_error == pytest.approx(0.0, abs=1e-60)
    assert not one.misfit


def test_tiles_without_a_floor_take_no_part():
    rng = np.random.default_rng(66)
    found = pattern(rng.normal(0.0, 2.0, (32, 48)), tile=16, relative=False)
    floor = np.full((2, 3), 1.0)
    floor[0, 1] = np.nan
    one = nonuniformity(found, NoiseFloor(variance=floor, dof=np.inf), unit=DN2)
    counted = np.isfinite(floor)
    expected = float(np.average(found.variance[counted], weights=found.dof[counted]) - 1.0)
    lines = one.row.value * (1.0 - 13.0 * 16.0 / 250.0) + one.column.value * (1.0 - 13.0 * 16.0 / 250.0)
    assert one.total.value == pytest.approx(expected + lines, rel=1e-9)
    with pytest.raises(ValueError, match="no tile"):
        nonuniformity(found, NoiseFloor(variance=np.full((2, 3), np.nan), dof=np.inf), unit=DN2)
