"""Fixed pattern about the quadratic surfaces of tiles: laws, and least squares written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fullwell.statistics.pattern import Pattern, pattern

EPS = float(np.finfo(np.float64).eps)
TILE = 32


def surface_of(tile: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quadratic surface of a tile by least squares."""
    v, h = np.meshgrid(*(np.linspace(-1, 1, side) for side in tile.shape), indexing="ij")
    terms = np.stack((np.ones_like(v), v, h, v * v, v * h, h * h), axis=-1).reshape(-1, 6)
    solution, *_rest = np.linalg.lstsq(terms, tile.ravel(), rcond=None)
    return (terms @ solution).reshape(tile.shape)


def oracle(plane: NDArray[np.float64], *, tile: int, relative: bool, use: NDArray[np.bool_]) -> dict[str, object]:
    """Return what `pattern` does, tile by tile and sum by sum."""
    grid = use.shape
    dof, variance, inverse = np.zeros(grid, int), np.full(grid, np.nan), np.full(grid, np.nan)
    residuals, counted = np.zeros_like(plane), np.zeros(plane.shape, bool)
    power = pixel_dof = row_dof = column_dof = 0
    for i, j in np.ndindex(grid):
        at = np.s_[i * tile : (i + 1) * tile, j * tile : (j + 1) * tile]
        part = plane[at]
        if not use[i, j] or min(part.shape) < 8:
            continue
        surface = surface_of(part)
        eps = part / surface - 1 if relative else part - surface
        m, n = part.shape
        dof[i, j] = m * n - 6
        variance[i, j] = np.sum(eps**2) / dof[i, j]
        inverse[i, j] = np.mean(surface**-2) if relative else 1.0
        power += np.sum((eps - eps.mean(axis=1, keepdims=True) - eps.mean(axis=0)) ** 2) - m * n * eps.mean() ** 2
        pixel_dof += m * n - m - n
        residuals[at], counted[at] = eps, True
    row_power = column_power = row_weight = column_weight = 0.0
    for i in range(grid[0]):
        band = np.s_[i * tile : (i + 1) * tile]
        width = counted[band][0].sum()
        if width:
            height = residuals[band].shape[0]
            row_power += np.sum(residuals[band].sum(axis=1) ** 2) / width
            row_dof += height - 3
            row_weight += (height - 3) * width
    for j in range(grid[1]):
        band = np.s_[:, j * tile : (j + 1) * tile]
        height = counted[band][:, 0].sum()
        if height:
            width = residuals[band].shape[1]
            column_power += np.sum(residuals[band].sum(axis=0) ** 2) / height
            column_dof += width - 3
            column_weight += (width - 3) * height
    return {
        "dof": dof,
        "variance": variance,
        "inverse_square": inverse,
        "row_mean_square": row_power / row_dof,
        "column_mean_square": column_power / column_dof,
        "pixel_mean_square": power / pixel_dof,
        "row_dof": row_dof,
        "column_dof": column_dof,
        "pixel_dof": pixel_dof,
        "columns": row_weight / row_dof,
        "rows": column_weight / column_dof,
    }


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("shape", [(64, 96), (75, 101), (64, 68)])
@pytest.mark.parametrize("dense", [True, False])
def test_it_is_least_squares_tile_by_tile(*, relative: bool, shape: tuple[int, int], dense: bool) -> None:
    rng = np.random.default_rng(shape[1])
    plane = rng.normal(300.0, 9.0, shape) * np.linspace(1.0, 0.6, shape[1])
    grid = -(-shape[0] // TILE), -(-shape[1] // TILE)
    use = np.ones(grid, bool) if dense else rng.random(grid) < 0.6
    use[0, 0] = True
    found = pattern(plane, tile=TILE, relative=relative, use=None if dense else use)
    for name, expected in oracle(plane, tile=TILE, relative=relative, use=use).items():
        np.testing.assert_allclose(getattr(found, name), expected, rtol=1e-10, err_msg=name)
    np.testing.assert_allclose(found.mean[0, 0], plane[:TILE, :TILE].mean(), rtol=1e-13)
    assert found.n.sum() == plane.size


@settings(max_examples=25)
@given(
    st.lists(st.floats(-50.0, 50.0), min_size=5, max_size=5),
    st.integers(8, 70),
    st.integers(8, 70),
    st.booleans(),
)
def test_a_quadratic_surface_leaves_nothing(
    terms: list[float],
    rows: int,
    columns: int,
    relative: bool,  # noqa: FBT001 - drawn by position
) -> None:
    v, h = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    a, b, c, d, e = terms
    plane = 400.0 + a * v + b * h + c * v * v + d * v * h + e * h * h
    found = pattern(plane, tile=16, relative=relative)
    # Six shares of up to 650 DN, each a sum over at most 256 pixels: no rounding is larger than 6 * 256 of its last.
    most = (6 * 256 * EPS * (1.0 if relative else 650.0)) ** 2
    assert np.all(found.variance[found.dof > 0] <= most * 256 / 58)
    assert found.pixel_mean_square <= most * 256


def near(value: float, expected: float, dof: int) -> None:
    """Compare a mean square with its expectation: four standard deviations of chi-square."""
    assert abs(value / expected - 1.0) <= 4.0 * np.sqrt(2.0 / dof)


def test_white_noise_is_the_same_in_rows_columns_and_pixels() -> None:
    plane = np.random.default_rng(2).normal(100.0, 3.0, (300, 420))
    found = pattern(plane, tile=TILE, relative=False)
    total = found.dof.sum()
    near(float(np.nansum(found.variance * found.dof) / total), 9.0, int(total))
    near(found.row_mean_square, 9.0, found.row_dof)
    near(found.column_mean_square, 9.0, found.column_dof)
    near(found.pixel_mean_square, 9.0, found.pixel_dof)


def components(found: Pattern) -> tuple[float, float, float]:
    """Return row, column and pixel variance."""
    row = (found.row_mean_square - found.pixel_mean_square) / found.columns
    column = (found.column_mean_square - found.pixel_mean_square) / found.rows
    return row, column, found.pixel_mean_square


def test_rows_columns_and_pixels_are_told_apart() -> None:
    rng = np.random.default_rng(3)
    shape = 320, 416
    by_row, by_column = rng.normal(0.0, 2.0, (shape[0], 1)), rng.normal(0.0, 1.5, (1, shape[1]))
    flat = np.full(shape, 100.0)
    only_rows = pattern(flat + by_row, tile=TILE, relative=False)
    row, column, pixel = components(only_rows)
    near(row, 4.0, only_rows.row_dof)
    rounding = TILE**2 * EPS * 4.0  # of a difference between sums of squares, each of as many pixels as a tile has
    assert abs(pixel) <= rounding
    assert abs(column) <= rounding
    only_columns = pattern(flat + by_column, tile=TILE, relative=False)
    row, column, pixel = components(only_columns)
    near(column, 2.25, only_columns.column_dof)
    assert abs(pixel) <= rounding
    assert abs(row) <= rounding
    every = pattern(flat + by_row + by_column + rng.normal(0.0, 3.0, shape), tile=TILE, relative=False)
    near(every.pixel_mean_square, 9.0, every.pixel_dof)
    near(every.row_mean_square, every.columns * 4.0 + 9.0, every.row_dof)
    near(every.column_mean_square, every.rows * 2.25 + 9.0, every.column_dof)


def test_shading_does_not_change_relative_pattern() -> None:
    rng = np.random.default_rng(4)
    sigma, shape = 0.007, (256, 320)
    own = rng.normal(0.0, sigma, shape)
    v, h = np.meshgrid(np.linspace(-1, 1, shape[0]), np.linspace(-1, 1, shape[1]), indexing="ij")
    shading = 500.0 * (1.0 - 0.25 * v * v - 0.25 * h * h - 0.05 * v)
    constant = pattern(1.0 + own, tile=64, relative=True)
    shaded = pattern(shading * (1.0 + own), tile=64, relative=True)
    # Both take six terms away, the shaded surface others by the shading's range in a tile; each of four such terms is
    # chi-square of six: at most 6 + 4 sqrt(12) sigma^2. The surfaces' own noise, sigma sqrt(6 / n), divides.
    extreme = [shading[i : i + 64, j : j + 64] for i in range(0, 256, 64) for j in range(0, 320, 64)]
    change = max(float(part.max() / part.min()) for part in extreme)
    terms = 4 * (6 + 4 * np.sqrt(12)) * change**2
    tolerance = terms / 64**2 + 2 * 4 * sigma * np.sqrt(6)
    np.testing.assert_allclose(shaded.variance, constant.variance, rtol=tolerance)
    near(float(np.mean(shaded.variance)), sigma**2, int(shaded.dof.sum()))
    np.testing.assert_allclose(shaded.mean[1, 2], np.mean(shading[64:128, 128:192]), rtol=4 * sigma / 64)


def test_noise_of_the_map_comes_in_by_the_inverse_square() -> None:
    rng = np.random.default_rng(5)
    shape = 256, 256
    shading = 300.0 * np.linspace(1.0, 0.4, shape[1]) * np.ones((shape[0], 1))
    found = pattern(shading + rng.normal(0.0, 4.0, shape), tile=64, relative=True)
    near(float(np.mean(found.variance / found.inverse_square)), 16.0, int(found.dof.sum()) // 2)


def test_strides_and_single_precision_do_not_matter() -> None:
    mosaic = np.random.default_rng(6).normal(200.0, 5.0, (130, 150)).astype(np.float32)
    view = mosaic[1::2, ::2]
    found = pattern(view, tile=TILE, relative=True)
    expected = pattern(view.astype(np.float64).copy(), tile=TILE, relative=True)
    np.testing.assert_array_equal(found.variance, expected.variance)
    assert found.row_mean_square == expected.row_mean_square


def test_tiles_that_cannot_count_do_not() -> None:
    plane = np.random.default_rng(7).normal(100.0, 1.0, (64, 103))
    plane[3, 5] = np.nan
    plane[40:, 64:96] = -1.0
    found = pattern(plane, tile=TILE, relative=True)
    assert (found.dof > 0).tolist() == [[False, True, True, False], [True, True, False, False]]
    assert np.isnan(found.variance).tolist() == (found.dof == 0).tolist()
    assert np.isnan(found.inverse_square).tolist() == (found.dof == 0).tolist()
    assert np.isnan(found.mean).tolist() == [[True, False, False, False], [False] * 4]
    alone = pattern(plane[:32, 32:96], tile=TILE, relative=True)
    np.testing.assert_allclose(found.variance[0, 1:3], alone.variance[0], rtol=1e-10)
    assert found.row_dof == 2 * 29


def test_nothing_to_measure_is_no_number() -> None:
    found = pattern(np.ones((7, 40)), tile=TILE, relative=False)
    assert found.dof.tolist() == [[0, 0]]
    assert np.isnan([found.row_mean_square, found.column_mean_square, found.pixel_mean_square]).all()
    assert (found.row_dof, found.column_dof, found.pixel_dof) == (0, 0, 0)


def test_small_tiles_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 8"):
        pattern(np.ones((16, 16)), tile=7, relative=False)
