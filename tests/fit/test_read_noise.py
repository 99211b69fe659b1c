import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from fullwell.fit.read_noise import analogue_read_noise, phase_effect, unrounded_noise
from fullwell.model.quantization import rounded_variance
from fullwell.units import DN2, Measured


@pytest.mark.parametrize(("noise", "tolerance"), [(0.5, 0.01), (0.3, 0.01), (0.2, 0.01), (0.12, 0.02)])
def test_T11_rounding_is_inverted(noise, tolerance):  # noqa: N802 - METHOD's name of the test
    rng = np.random.default_rng(11)
    pixels, frames = 400_000, 4
    level = 64.0 + 0.6 * rng.standard_normal(pixels)
    codes = np.rint(level + noise * rng.standard_normal((frames, pixels)))
    variances = codes.var(axis=0, ddof=1)
    measured = Measured.normal(float(variances.mean()), float(variances.std() / np.sqrt(pixels)), DN2)
    found = analogue_read_noise(measured, spatial_spread_dn=0.6)
    assert abs(found.noise.value / noise - 1.0) <= tolerance
    assert abs(found.noise.value - noise) <= 4.0 * found.noise.std_error
    assert not found.quantization_limited


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.2])
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.25, 0.4, 0.45, 0.5])
def test_unknown_phase_leaves_an_interval_that_holds_the_truth(phase, spread):
    """At the edge of two codes any small noise looks like 0.41: that was once told with an error of a hundredth."""
    rng = np.random.default_rng(33)
    pixels, frames = 20_000, 4
    level = phase + spread * rng.standard_normal(pixels)
    held = 0
    for noise in (0.03, 0.1, 0.2, 0.3, 0.4):
        codes = np.rint(level + noise * rng.standard_normal((frames, pixels)))
        variances = codes.var(axis=0, ddof=1)
        measured = Measured.normal(float(variances.mean()), float(variances.std() / np.sqrt(pixels)), DN2)
        seen = max(float(codes.mean(axis=0).var(ddof=1)) - measured.value / frames, 0.0) ** 0.5
        found = analogue_read_noise(measured, spatial_spread_dn=seen, n=codes.size)
        held += found.noise.ci95[0] <= noise <= found.noise.ci95[1]
        if measured.value < rounded_variance(0.45):
            assert found.flags == ("quantization-limited",)
    assert held >= 4


def test_phase_effect_fades_with_noise_and_with_spread():
    effects = [phase_effect(noise) for noise in (0.3, 0.4, 0.5, 0.7, 1.0)]
    assert effects == sorted(effects, reverse=True)
    assert effects[-1] < 1e-6
    assert phase_effect(0.3, spread=0.5) < 0.01 * phase_effect(0.3)
    assert 0.0 < phase_effect(1.24) < 1e-12
    assert phase_effect(1.26) == phase_effect(0.3, spread=1.3) == 0.0


def summed_effect(noise: float, spread: float) -> float:
    """Return how far levels about a code or an edge are off the mean over phases, summed level by level."""
    levels = np.linspace(-8.5, 8.5, 1 + round(17 * 6 * max(spread / noise, 1.0))) * spread
    weights = np.exp(-0.5 * (levels / spread) ** 2)
    edges = np.arange(-14.0, 15.0) - 0.5
    effects = []
    for phase in (0.0, 0.5):
        shares = np.diff(norm.cdf((edges - phase - levels[:, np.newaxis]) / noise), axis=1)
        codes = edges[:-1] + 0.5 - np.rint(levels)[:, np.newaxis]
        variances = (shares * codes**2).sum(axis=1) - (shares * codes).sum(axis=1) ** 2
        effects.append(abs(np.average(variances, weights=weights) - rounded_variance(noise)))
    return max(effects)


@pytest.mark.parametrize("noise", [0.02, 0.1, 0.2, 0.4])
@pytest.mark.parametrize("spread", [0.05, 0.3, 0.5, 0.8, 1.1])
def test_phase_effect_is_that_of_levels_summed_one_by_one(noise, spread):
    """Twenty-one levels stood for all: for little noise the effect came out as large as the variance."""
    least = max(max(noise**2 - summed_effect(noise, spread), 0.0) ** 0.5, 0.7 * noise)
    assert phase_effect(noise, spread=spread) == pytest.approx(summed_effect(least, spread), rel=1e-9, abs=1e-13)


def test_phase_joins_the_error_where_levels_do_not_spread():
    measured = Measured.normal(rounded_variance(0.46), 1e-4, DN2)
    narrow = analogue_read_noise(measured, spatial_spread_dn=0.0)
    wide = analogue_read_noise(measured, spatial_spread_dn=1.0)
    assert narrow.noise.value == pytest.approx(wide.noise.value)
    assert narrow.noise.std_error > 10.0 * wide.noise.std_error


def test_published_number_of_the_real_sensor():
    """imx541: 0.886 DN with quantization, 0.838 without."""
    found = analogue_read_noise(Measured.normal(0.886**2, 1e-5, DN2), spatial_spread_dn=0.3)
    assert found.noise.value == pytest.approx(0.838, abs=5e-4)


def test_a_variance_of_zero_is_an_upper_limit():
    found = analogue_read_noise(Measured.normal(0.0, 1e-6, DN2), spatial_spread_dn=1.0)
    assert found.noise.value == 0.0
    assert found.noise.std_error is None
    assert "upper-limit" in found.flags


@given(noise=st.floats(0.02, 30.0), step=st.sampled_from([0.25, 1.0, 4.0, 16.0]))
def test_inversion_undoes_the_rounding_law(noise, step):
    assert unrounded_noise(rounded_variance(noise * step, step=step), step=step) == pytest.approx(
        noise * step, rel=1e-9
    )


@pytest.mark.parametrize("variance", [math.nan, math.inf])
def test_no_number_is_inverted_to_itself(variance):
    assert str(unrounded_noise(variance)) == str(variance)
