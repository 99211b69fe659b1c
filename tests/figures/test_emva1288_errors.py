"""Standard errors of EMVA 1288 figures against the scatter of repeated campaigns; biases of the literal split."""

import numpy as np
import pytest

from fullwell.figures.emva1288.nonuniformity import split_corrected, split_literal, stack_moments
from fullwell.figures.emva1288.sensitivity import fit_range, fit_system_gain
from fullwell.figures.emva1288.spline_gate import spline_gate
from fullwell.figures.emva1288.sweep import Sweep
from fullwell.statistics.high_pass import filtered
from fullwell.statistics.pairs import pair_of

STEPS, N, GAIN, DARK = 50, 10**6, 0.4, 1.005
SETS = 600


def campaign(rng: np.random.Generator) -> Sweep:
    """Return a sweep whose variances scatter as those of normal pixels do: chi-square with N degrees of freedom."""
    signal = np.linspace(80.0, 4000.0, STEPS)
    true, dark = DARK + GAIN * signal, np.full(STEPS, DARK)
    variance, dark_variance = (one * rng.chisquare(N, STEPS) / N for one in (true, dark))
    means = signal + rng.normal(0.0, np.sqrt(true / (2 * N)))
    return Sweep(
        n=N,
        exposure_s=signal / 4e5,
        photons=signal / 0.24,
        mean=means + 60.0,
        dark_mean=np.full(STEPS, 60.0),
        variance=variance,
        dark_variance=dark_variance,
        mean_difference=np.zeros(STEPS),
        spatial_variance=np.zeros(STEPS),
        top_fraction=np.zeros(STEPS),
        dark_measured=np.ones(STEPS, np.bool_),
    )


def test_system_gain_scatters_as_its_standard_error_says():
    rng = np.random.default_rng(11)
    found, errors = [], []
    for _ in range(SETS):
        sweep = campaign(rng)
        gain = fit_system_gain(sweep, fit_range(sweep, saturation_signal=4000.0))
        assert gain is not None
        found.append(gain.line.slope)
        errors.append(gain.slope_error)
    scatter = float(np.std(found, ddof=1))
    # The scatter of 600 sets is known to 1/sqrt(2 * 599), 2.9 %; four times that is 12 %, within the 15 % asked for.
    assert np.mean(errors) / scatter == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * (SETS - 1)))
    assert np.mean(found) == pytest.approx(GAIN, abs=4.0 * scatter / np.sqrt(SETS))


def test_the_floor_of_the_gate_is_what_an_ideal_camera_shows():
    rng = np.random.default_rng(12)
    found = []
    for _ in range(100):
        sweep = campaign(rng)
        chosen = fit_range(sweep, saturation_signal=4000.0)
        gain = fit_system_gain(sweep, chosen)
        assert gain is not None
        gate = spline_gate(sweep, chosen, line=gain.line, saturation_signal=4000.0)
        assert gate is not None
        found.append((gate.deviation, gate.floor))
    deviations, floors = np.array(found).T
    error = deviations.std(ddof=1) / np.sqrt(deviations.size)
    assert deviations.mean() == pytest.approx(floors.mean(), abs=4.0 * error)
    assert floors.mean() == pytest.approx(0.0029, rel=0.1)  # EMVA1288 3: 0.29 % at 10^6 pixels, P = 8


def test_high_passed_splits():
    """EMVA1288 6: the corrected split is unbiased, the literal one loses 11 % of row and column variance."""
    rng, shape, frames = np.random.default_rng(13), (150, 200), 16
    column, row, pixel = 0.5, 0.8, 1.0
    literal, corrected, errors = [], [], []
    for _ in range(60):
        image = rng.normal(0.0, np.sqrt(pixel + 1.0 / frames), shape)
        image += rng.normal(0.0, np.sqrt(column), shape[1]) + rng.normal(0.0, np.sqrt(row), (shape[0], 1))
        moments = stack_moments(filtered(image), frames=frames, temporal=1.0, filtered=True)
        for split, kept in ((split_literal(moments), literal), (split_corrected(moments), corrected)):
            kept.append((split.column, split.row, split.pixel))
        errors.append((split.column_error, split.row_error, split.pixel_error))
    scatter = np.std(corrected, axis=0, ddof=1)
    error = scatter / np.sqrt(60)
    truth = np.array([column, row, pixel])
    assert np.all(np.abs(np.mean(corrected, axis=0) - truth) < 4.0 * error)
    expected = np.array([0.889062236 * column, 0.889062236 * row, 0.988495108 * pixel])
    assert np.all(np.abs(np.mean(literal, axis=0) - expected) < 4.0 * error + 0.002)
    assert np.mean(errors, axis=0) / scatter == pytest.approx(np.ones(3), abs=4.0 / np.sqrt(2 * 59))


def test_pair_covariances_scatter_about_zero_where_there_is_no_pattern():
    rng = np.random.default_rng(14)
    frames = rng.normal(100.0, 5.0, (200, 2, 48, 48)).round().astype(np.uint16)
    found = np.array([pair_of(first, second).spatial_variance for first, second in frames])
    negative = float(np.mean(found < 0.0))
    assert negative == pytest.approx(0.5, abs=4.0 * 0.5 / np.sqrt(200))
    expected = (25.0 + 1 / 12) / 48.0
    assert found.std(ddof=1) == pytest.approx(expected, rel=4.0 / np.sqrt(2 * 199))
