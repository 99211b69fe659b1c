"""Bins as they come: few, none, dark, flat, tiny, with holes, seen off axis."""

from dataclasses import replace

import numpy as np
import pytest

from fullwell.fit.shading.data import local_mean, shading_data
from fullwell.fit.shading.extent import corner_and_edges, optical_axis
from fullwell.fit.shading.selection import fit_shading
from fullwell.statistics.bins import Bins


def bins_of(mean, n=64):
    rows, columns = np.shape(mean)
    return Bins(
        size=8,
        n=np.where(np.isfinite(mean), n, 0).astype(np.int64),
        mean=np.asarray(mean, dtype=np.float64),
        rows=np.arange(rows) * 8 + 3.5,
        columns=np.arange(columns) * 8 + 3.5,
        plane_shape=(rows * 8, columns * 8),
        defective=0,
        saturated=0,
    )


def test_black_comes_off_and_variances_are_those_of_a_mean():
    mean = np.full((3, 4), 164.0)
    mean[0, 0] = np.nan
    data = shading_data(
        bins_of(mean),
        black_dn=64.0,
        temporal_variance_dn2=lambda signal: 2.0 + 0.17 * signal,
        frames=5,
        prnu=0.007,
        pitch_um=2.8,
        focal_length_mm=4.38,
    )
    assert np.isnan(data.signal_dn[0, 0])
    assert data.signal_dn[1, 1] == 100.0
    assert data.temporal_variance_dn2[1, 1] == pytest.approx(19.0 / (5 * 64))
    assert data.fixed_variance[1, 1] == pytest.approx(0.007**2 / 64)
    assert data.used.sum() == 11
    assert data.focal_length_pixels == pytest.approx(4380.0 / 2.8)
    assert replace(data, pitch_um=None).focal_length_pixels is None


def test_variances_of_no_use_are_refused():
    flat = bins_of(np.full((3, 4), 164.0))
    with pytest.raises(ValueError, match="not above zero"):
        shading_data(flat, black_dn=64.0, temporal_variance_dn2=0.0, frames=5, prnu=0.0)
    with pytest.raises(ValueError, match="no bin is left"):
        shading_data(bins_of(np.full((3, 4), np.nan)), black_dn=64.0, temporal_variance_dn2=1.0, frames=5, prnu=0.0)


def test_the_local_mean_is_that_of_five_by_five():
    values = np.random.default_rng(1).normal(size=(9, 11))
    values[4, 5] = np.nan
    found = local_mean(values)
    for row, column in ((0, 0), (4, 5), (8, 3), (5, 10)):
        window = values[max(row - 2, 0) : row + 3, max(column - 2, 0) : column + 3]
        assert found[row, column] == pytest.approx(np.nanmean(window), abs=1e-12)
    assert np.isnan(local_mean(np.full((8, 8), np.nan))).all()


@pytest.mark.parametrize("bins", [(15, 20), (9, 9), (20, 8)])
def test_tiny_planes(bins, bench):
    plane = bench(bins=bins)
    data = plane.data(500.0 * plane.on_bins(plane.cosine), np.random.default_rng(1))
    fits = fit_shading(data)
    assert "cos4" in fits.models
    corners = [
        plane.cosine(row, column) for row in (0.0, plane.shape[0] - 1.0) for column in (0.0, plane.shape[1] - 1.0)
    ]
    for name in ("cos4", fits.chosen):
        corner = corner_and_edges(fits.models[name]).corner
        assert abs(corner.value - np.mean(corners)) < 4.5 * corner.std_error


@pytest.mark.parametrize(
    ("bins", "fitted"),
    [((1, 1), set()), ((2, 2), {"cos4-fixed"}), ((1, 50), {"cos4-fixed"}), ((2, 3), {"cos4-fixed", "cos4"})],
)
def test_fewer_bins_than_terms_are_said_by_model(bins, fitted, bench):
    plane = bench(bins=bins)
    data = plane.data(np.full(bins, 500.0), np.random.default_rng(1))
    if not fitted:
        with pytest.raises(ValueError, match="poly22: 6 terms need more than the 1 bins"):
            fit_shading(data)
        return
    fits = fit_shading(data)
    assert set(fits.models) == fitted
    assert all(" bins" in why for why in fits.failures.values())
    assert np.isfinite(corner_and_edges(fits.best).corner.value)


@pytest.mark.parametrize("level", [500.0, 5.0])
def test_a_constant_plane(level, bench):
    plane = bench(bins=(60, 80))
    fits = fit_shading(plane.data(np.full(plane.bins, level), np.random.default_rng(1)))
    assert "cos4" in fits.models
    corner = corner_and_edges(fits.best).corner
    assert abs(corner.value - 1.0) < 4.5 * corner.std_error


def test_a_plane_without_any_noise(bench):
    plane = bench(bins=(60, 80))
    data = plane.data(np.full(plane.bins, 500.0), np.random.default_rng(1))
    fits = fit_shading(replace(data, signal_dn=np.full(plane.bins, 500.0)))
    for model in fits.models.values():
        assert np.isfinite(model.values).all()
        assert np.isfinite(model.covariance).all()
    spline = fits.models["p-spline"]
    rows, columns = (np.arange(0.0, size, 40.0) for size in spline.plane_shape)
    found = spline.surface(rows[:, None], columns[None]) / spline.maximum_dn
    np.testing.assert_allclose(found, 1.0, rtol=1e-7)  # the least penalty is 1e-8
    assert optical_axis(fits.models["cos4"]) is None


def test_a_centre_outside_the_plane(bench):
    plane = bench(bins=(60, 80))
    row, column, focal = -150.0, 300.0, 500.0
    signal = plane.on_bins(lambda v, h: 500.0 * (1.0 + ((v - row) ** 2 + (h - column) ** 2) / focal**2) ** -2.0)
    fits = fit_shading(plane.data(signal, np.random.default_rng(1)))
    axis = optical_axis(fits.models["cos4"])
    for found, truth in ((axis.row, row), (axis.column, column), (axis.focal_length, focal)):
        assert abs(found.value - truth) < 4.5 * found.std_error
    assert fits.best.centre[0] == 0.0


def test_a_hole_and_a_bright_middle_left_out(bench):
    """Saturation leaves out the middle, where nobody then knows the maximum well; the law goes through it."""
    plane = bench(bins=(95, 126))
    signal = 500.0 * plane.on_bins(plane.cosine)
    data = plane.data(signal, np.random.default_rng(1))
    holed = data.signal_dn.copy()
    holed[30:70, 40:90] = np.nan
    fits = fit_shading(replace(data, signal_dn=holed))
    assert not fits.failures
    assert fits.models["p-spline"].dof < 95 * 126 - 40 * 50
    axis = optical_axis(fits.models["cos4"])
    assert abs(axis.row.value - 0.52 * plane.shape[0]) < 4.5 * axis.row.std_error
    middle = fits.models["p-spline"].surface(0.52 * plane.shape[0], 0.49 * plane.shape[1])
    assert middle == pytest.approx(500.0, rel=0.02)  # carried over the hole by smoothness


def test_single_bins_below_black_count_like_others(bench):
    plane = bench(bins=(60, 80))
    signal = 0.3 * plane.on_bins(plane.cosine)
    data = plane.data(signal, np.random.default_rng(1))
    assert (data.signal_dn < 0.0).any()
    fits = fit_shading(data)
    top = fits.models["cos4"].maximum_dn
    error = np.sqrt(fits.models["cos4"].covariance[0, 0])
    assert abs(top - 0.3) < 4.5 * error


@pytest.mark.parametrize("level", [-5.0, 0.0])
def test_a_plane_in_the_dark_is_refused(level, bench):
    plane = bench(bins=(60, 80))
    data = plane.data(np.full(plane.bins, level), np.random.default_rng(1))
    dark = replace(data, signal_dn=data.signal_dn - max(np.mean(data.signal_dn), 0.0) - 1e-3)
    with pytest.raises(ValueError, match="no light above black"):
        fit_shading(dark)


def test_what_is_no_number_is_refused_or_left_out(bench):
    plane = bench(bins=(30, 40))
    data = plane.data(np.full(plane.bins, 500.0), np.random.default_rng(1))
    with pytest.raises(ValueError, match="no bin is left"):
        fit_shading(replace(data, signal_dn=np.full(plane.bins, np.nan)))
    variance = data.temporal_variance_dn2.copy()
    variance[3, 3] = np.nan
    with pytest.raises(ValueError, match="variance above zero"):
        fit_shading(replace(data, temporal_variance_dn2=variance))
    signal = data.signal_dn.copy()
    signal[3, 3] = np.inf
    fits = fit_shading(replace(data, signal_dn=signal), models=["poly22"])
    assert fits.best.dof == 30 * 40 - 1 - 6


def test_unknown_models_and_unknown_focal_lengths(bench):
    plane = bench(bins=(30, 40))
    data = plane.data(np.full(plane.bins, 500.0), np.random.default_rng(1))
    with pytest.raises(ValueError, match="'poly33'"):
        fit_shading(data, models=["poly33"])
    without = replace(data, focal_length_mm=None)
    assert "cos4-fixed" not in fit_shading(without, models=["cos4-fixed", "poly22"]).models
    with pytest.raises(ValueError, match="no shading model"):
        fit_shading(without, models=["cos4-fixed"])
