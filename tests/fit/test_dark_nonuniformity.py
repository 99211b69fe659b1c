from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from fullwell.fit.nonuniformity import dark_nonuniformity
from fullwell.fit.variance_components import variance_components
from fullwell.statistics.pattern import pattern
from fullwell.statistics.series import TileStatistics
from fullwell.units import DN2

SETS = 600
SHAPE = (4, 24, 32)
TRUTH = {"t": 0.1, "v": 0.05, "h": 0.03, "tv": 0.1, "th": 0.06, "vh": 0.4, "tvh": 1.0}
HOT_SHARE, HOT_DN = 0.002, 8.0


def _effect(rng, name, shape):
    edges = [size if letter in name else 1 for letter, size in zip("tvh", shape, strict=True)]
    return np.sqrt(TRUTH[name]) * rng.standard_normal(edges)


def _burst(rng, shape, fixed=None):
    """Frames x[t, v, h]; ``fixed`` in place of a new fixed pattern."""
    pattern_dn = sum(_effect(rng, name, shape) for name in ("v", "h", "vh")) if fixed is None else fixed
    return pattern_dn + sum(_effect(rng, name, shape) for name in ("t", "tv", "th", "tvh"))


def _tiles(frames, size):
    """By definition where it matters to the test: variances and their degrees of freedom."""
    mean = frames.mean(axis=0)
    spatial = pattern(mean, tile=size, relative=False)
    rows, columns = (side // size for side in mean.shape)
    tiled = frames.reshape(len(frames), rows, size, columns, size)
    still = tiled - tiled.mean(axis=(2, 4), keepdims=True)
    return TileStatistics(
        size=size,
        n=spatial.n,
        mean=spatial.mean,
        temporal_variance=still.var(axis=0, ddof=1).mean(axis=(1, 3)) * size**2 / (size**2 - 1.0),
        temporal_dof=(spatial.n - 1) * (len(frames) - 1),
        spatial_variance=spatial.variance,
        spatial_dof=spatial.dof,
        lowest=np.zeros_like(spatial.n),
        highest=np.zeros_like(spatial.n),
        n_lowest=np.zeros_like(spatial.n),
        n_highest=np.zeros_like(spatial.n),
    )


def test_parts_are_those_of_the_layout_and_add_up(mean_squares_of):
    frames = _burst(np.random.default_rng(71), SHAPE)
    squares = mean_squares_of(frames[np.newaxis])[0]
    found, parts = dark_nonuniformity(squares, SHAPE), variance_components(squares, SHAPE)
    for one, other in ((found.row, parts.v), (found.column, parts.h), (found.pixel, parts.vh)):
        assert one.value == pytest.approx(other.value, rel=1e-9)
        assert one.std_error == pytest.approx(other.std_error, rel=1e-9)
        assert one.ci95 == pytest.approx(other.ci95, rel=1e-6)
    assert found.total.value == pytest.approx(parts.v.value + parts.h.value + parts.vh.value, rel=1e-9)
    assert found.total.unit == DN2
    assert (found.between_tiles_p, found.misfit) == (1.0, False)


def test_total_covers_and_repeats_scatter_by_the_repeat_error(mean_squares_of):
    rng = np.random.default_rng(72)
    truth = TRUTH["v"] + TRUTH["h"] + TRUTH["vh"]
    found, pulls = [], []
    for _ in range(SETS):
        fixed = sum(_effect(rng, name, SHAPE) for name in ("v", "h", "vh"))
        bursts = np.stack([_burst(rng, SHAPE, fixed) for _ in range(2)])
        first, second = (dark_nonuniformity(squares, SHAPE) for squares in mean_squares_of(bursts))
        found.append(first.total)
        pulls.append((first.total.value - second.total.value) / np.hypot(first.repeat_error, second.repeat_error))
    values = np.array([one.value for one in found])
    assert abs(values.mean() - truth) <= 4.0 * values.std(ddof=1) / np.sqrt(SETS)
    covered = np.mean([one.ci95[0] <= truth <= one.ci95[1] for one in found])
    assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / SETS), covered
    assert abs(np.std(pulls) - 1.0) <= 4.0 / np.sqrt(2 * SETS), np.std(pulls)


def test_tiles_agree_where_rows_and_columns_are_all_there_is_to_differ(mean_squares_of):
    """Rows shared by tiles side by side must not pass for a difference between tiles."""
    rng = np.random.default_rng(73)
    shape, sets = (4, 32, 48), 400
    p_values = []
    for _ in range(sets):
        frames = _burst(rng, shape)
        squares = mean_squares_of(frames[np.newaxis])[0]
        p_values.append(dark_nonuniformity(squares, shape, tiles=_tiles(frames, 8)).between_tiles_p)
    size = np.mean(np.array(p_values) < 0.05)
    widened = norm.sf(norm.isf(0.05) / np.sqrt(1.0 + 12.0 / 58 / 2))  # kurtosis of a variance of 58 degrees of freedom
    window = 4.0 * np.sqrt(0.05 * 0.95 / sets)
    assert 0.05 - window <= size <= widened + window, size


def test_hot_pixels_widen_the_errors_by_what_tiles_scatter(mean_squares_of):
    rng = np.random.default_rng(74)
    shape, sets = (2, 96, 96), 300
    truth = TRUTH["v"] + TRUTH["h"] + TRUTH["vh"] + HOT_SHARE * HOT_DN**2
    covered = []
    for _ in range(sets):
        frames = _burst(rng, shape) + HOT_DN * (rng.random(shape[1:]) < HOT_SHARE)
        squares = mean_squares_of(frames[np.newaxis])[0]
        both = [dark_nonuniformity(squares, shape, tiles=tiles).total for tiles in (None, _tiles(frames, 16))]
        covered.append([one.ci95[0] <= truth <= one.ci95[1] for one in both])
    alone, with_tiles = np.mean(covered, axis=0)
    assert with_tiles >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / sets), with_tiles
    assert alone < with_tiles - 0.05, alone


def test_one_frame_has_no_noise_to_take_off(mean_squares_of):
    frames = _burst(np.random.default_rng(75), (2, 8, 8))
    squares = mean_squares_of(frames[np.newaxis])[0]
    with pytest.raises(ValueError, match="two frames"):
        dark_nonuniformity(squares, (1, 8, 8))


def test_tiles_too_small_for_a_surface_say_nothing(mean_squares_of):
    frames = _burst(np.random.default_rng(76), (4, 8, 8))
    squares = mean_squares_of(frames[np.newaxis])[0]
    none = replace(_tiles(frames, 8), spatial_dof=np.zeros((1, 1), np.int64))
    assert dark_nonuniformity(squares, (4, 8, 8), tiles=none) == dark_nonuniformity(squares, (4, 8, 8))
