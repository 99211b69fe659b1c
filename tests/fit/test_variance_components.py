import numpy as np
import pytest

from fullwell.fit.censored import is_clipped_low
from fullwell.fit.legacy.read_noise import legacy_read_noise
from fullwell.fit.read_noise import analogue_read_noise, excess_ratio
from fullwell.fit.variance_components import (
    EFFECTS,
    degrees_of_freedom,
    grand_mean_variance,
    temporal_variance,
    variance_components,
)
from fullwell.statistics.series import LegacyBurst

TRUTH = {"t": 0.2, "v": 0.05, "h": 0.03, "tv": 0.1, "th": 0.06, "vh": 0.4, "tvh": 1.0}


def _layout(rng, *, sets, shape, truth):
    """x[set, t, v, h] with independent Gaussian effects."""
    x = np.zeros((sets, *shape))
    for name, variance in truth.items():
        edges = [size if letter in name else 1 for letter, size in zip("tvh", shape, strict=True)]
        x += np.sqrt(variance) * rng.standard_normal((sets, *edges))
    return x


@pytest.fixture
def analysed(mean_squares_of):
    shape, sets = (8, 12, 16), 2000
    x = _layout(np.random.default_rng(13), sets=sets, shape=shape, truth=TRUTH)
    return x, shape, mean_squares_of(x)


def test_T13_anova_is_unbiased_and_its_intervals_cover(analysed):  # noqa: N802 - METHOD's name of the test
    _, shape, squares = analysed
    found = [variance_components(one, shape) for one in squares]
    for effect in EFFECTS:
        values = np.array([getattr(one, effect).value for one in found])
        deviation = (values.mean() - TRUTH[effect]) / (values.std(ddof=1) / np.sqrt(len(found)))
        assert abs(deviation) <= 3.5, (effect, deviation)
        intervals = np.array([getattr(one, effect).ci95 for one in found])
        covered = np.mean((intervals[:, 0] <= TRUTH[effect]) & (TRUTH[effect] <= intervals[:, 1]))
        assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / len(found)), (effect, covered)


def test_temporal_variance_is_the_mean_of_the_pixels_variances(analysed):
    x, shape, squares = analysed
    for one in range(20):
        expected = x[one].var(axis=0, ddof=1).mean()
        assert temporal_variance(squares[one], shape).value == pytest.approx(expected, rel=1e-12)


def test_temporal_variance_covers_with_row_and_column_noise(mean_squares_of):
    """Row noise of 30 % of the variance: pixels of a row share it, so chi-square on pixels would cover far less."""
    shape, sets = (5, 20, 24), 1500
    truth = {"tv": 0.3, "th": 0.1, "vh": 0.5, "tvh": 1.0}
    x = _layout(np.random.default_rng(31), sets=sets, shape=shape, truth=truth)
    found = [temporal_variance(one, shape) for one in mean_squares_of(x)]
    covered = np.mean([one.ci95[0] <= 1.4 <= one.ci95[1] for one in found])
    assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets), covered
    naive = np.mean([abs(one.value - 1.4) <= 1.96 * one.value * np.sqrt(2.0 / (4 * 480)) for one in found])
    assert naive < 0.85


def test_grand_mean_variance_is_that_of_the_mean(analysed):
    x, shape, squares = analysed
    frames, rows, columns = shape
    found = [grand_mean_variance(one, shape) for one in squares]
    fixed = TRUTH["v"] / rows + TRUTH["h"] / columns + TRUTH["vh"] / (rows * columns)
    pixel = TRUTH["tv"] / rows + TRUTH["th"] / columns + TRUTH["tvh"] / (rows * columns)
    expected = {
        "total": fixed + (TRUTH["t"] + pixel) / frames,
        "temporal": (TRUTH["t"] + pixel) / frames,
    }
    for name, truth in expected.items():
        values = np.array([getattr(one, name).value for one in found])
        assert abs(values.mean() - truth) <= 4.0 * values.std(ddof=1) / np.sqrt(len(found)), name
    scatter = x.mean(axis=(1, 2, 3)).var(ddof=1)
    assert abs(scatter / expected["total"] - 1.0) <= 4.0 * np.sqrt(2.0 / len(found))
    for one, frame in zip(found[:10], x[:10], strict=True):
        assert one.temporal.value == pytest.approx(frame.mean(axis=(1, 2)).var(ddof=1) / frames, rel=1e-12)
        assert one.temporal.dof == pytest.approx(frames - 1)


def test_degrees_of_freedom_add_up():
    dof = degrees_of_freedom((4, 5, 6))
    assert sum(dof.values()) == 4 * 5 * 6 - 1


def test_T10_read_noise_flows(mean_squares_of):  # noqa: N802 - METHOD's name of the test
    frames, edge, sets, noise = 5, 24, 2000, 1.5
    rng = np.random.default_rng(10)
    level = 64.0 + rng.uniform(-0.5, 0.5, (sets, 1, 1, 1))
    x = np.rint(level + noise * rng.standard_normal((sets, frames, edge, edge)))
    shape, pixels = (frames, edge, edge), edge * edge
    pairs = [(i, j) for i in range(frames) for j in range(i + 1, frames)]
    pair = np.mean([(x[:, i] - x[:, j]).var(axis=(1, 2), ddof=1) for i, j in pairs], axis=0)
    residual = (x - x.mean(axis=1, keepdims=True)).var(axis=(2, 3), ddof=1).mean(axis=1)
    found, ratios = [], []
    for one, squares in enumerate(mean_squares_of(x)):
        burst = LegacyBurst(
            frames=frames, n=pixels, pair_variance=float(pair[one]), residual_variance=float(residual[one])
        )
        flows = legacy_read_noise(burst)
        ratios.append(flows.pair_difference.value / flows.burst_mean.value)
        scatter = x[one].var(axis=0, ddof=1).var(ddof=1)
        variance = temporal_variance(squares, shape, pixel_scatter_dn4=float(scatter))
        found.append(analogue_read_noise(variance, spatial_spread_dn=1.0).noise)
    np.testing.assert_allclose(ratios, 1.1180, atol=0.001)
    assert abs(np.mean([one.value for one in found]) / noise - 1.0) <= 0.001
    covered = np.mean([one.ci95[0] <= noise <= one.ci95[1] for one in found])
    assert 0.935 <= covered <= 0.965, covered
    clipped = np.maximum(x[0], 64).astype(np.int64)
    assert is_clipped_low(64, np.bincount(clipped.ravel() - 64))


def test_telegraph_noise_widens_the_error(mean_squares_of):
    """METHOD 3.1: 1 % of the pixels jump by 8 DN; chi-square covers 84 %, the scatter of the pixels 94 %."""
    frames, edge, sets = 5, 40, 600
    rng = np.random.default_rng(35)
    jumps = (rng.random((sets, 1, edge, edge)) < 0.01) * rng.choice([-8.0, 8.0], (sets, frames, edge, edge))
    x = 1.5 * rng.standard_normal((sets, frames, edge, edge)) + jumps
    truth = 1.5**2 + 0.01 * 64.0
    shape, covered, excess = (frames, edge, edge), [], []
    for one, squares in enumerate(mean_squares_of(x)):
        scatter = float(x[one].var(axis=0, ddof=1).var(ddof=1))
        with_scatter = temporal_variance(squares, shape, pixel_scatter_dn4=scatter)
        plain = temporal_variance(squares, shape)
        covered.append([v.ci95[0] <= truth <= v.ci95[1] for v in (with_scatter, plain)])
        excess.append(excess_ratio(scatter, with_scatter.value, frames=frames, pixels=edge * edge).value)
    by_scatter, by_chi_square = np.mean(covered, axis=0)
    assert by_scatter >= 0.94 - 4.0 * np.sqrt(0.94 * 0.06 / sets)
    assert by_chi_square < by_scatter - 0.05
    assert np.mean(excess) > 2.0


def test_excess_ratio_of_gaussian_noise_is_one():
    """To second order in 1 / n the ratio's bias is -2 / (n dof): 6 from its denominator, -8 from their covariance."""
    rng = np.random.default_rng(36)
    dof, pixels, sets = 4, 2500, 400
    pulls = []
    for _ in range(sets):
        variances = rng.chisquare(dof, pixels) / dof
        ratio = excess_ratio(float(variances.var(ddof=1)), float(variances.mean()), frames=dof + 1, pixels=pixels)
        pulls.append((ratio.value - 1.0 + 2.0 / (pixels * dof)) / ratio.std_error)
    assert abs(np.mean(pulls)) <= 4.0 / np.sqrt(sets)
    assert np.std(pulls) <= 1.0 + 4.0 / np.sqrt(2 * sets)
