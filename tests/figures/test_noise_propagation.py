import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.figures.noise_model import (
    DSNU_DN2,
    K_DARK,
    K_FPN,
    K_SHOT,
    READ_E2,
    SYSTEM_GAIN,
    Conventions,
    GivenModel,
)
from fullwell.figures.noise_translation import translated
from fullwell.figures.propagation import Ingredient, propagated
from fullwell.units import DN, DN2, DN_PER_ELECTRON, ELECTRON2, ONE, Measured

POSITIVE = st.floats(0.1, 10.0)
ERRORS = st.floats(1e-4, 0.05)


def ingredient(value, error, *, dof=None, fit=None):
    return Ingredient(measured=Measured.student(value, error, dof, ONE), fit=fit)


@given(a=POSITIVE, b=POSITIVE, error_a=ERRORS, error_b=ERRORS)
def test_independent_relative_errors_of_a_quotient_add_in_squares(a, b, error_a, error_b):
    parts = [ingredient(a, a * error_a), ingredient(b, b * error_b)]
    quotient = propagated(lambda values: float(values[0] / values[1]), parts, unit=ONE)
    assert quotient.value == a / b
    assert quotient.std_error == pytest.approx(a / b * math.hypot(error_a, error_b), rel=1e-5)


@given(correlation=st.floats(-1.0, 1.0), error_a=ERRORS, error_b=ERRORS)
def test_errors_of_one_fit_are_never_too_small(correlation, error_a, error_b):
    """Whatever the correlation of k_dark and k_shot is, the error that it leaves kd^2 / ks^4 is at most ours."""
    parts = [ingredient(2.0, 2.0 * error_a, fit="f"), ingredient(3.0, 3.0 * error_b, fit="f")]
    ours = propagated(lambda values: float(values[0] / values[1] ** 2), parts, unit=ONE)
    relative2 = error_a**2 + 4.0 * error_b**2 - 4.0 * correlation * error_a * error_b
    assert ours.std_error is not None
    assert ours.std_error >= 2.0 / 9.0 * math.sqrt(max(relative2, 0.0)) * (1.0 - 1e-5)
    assert ours.std_error == pytest.approx(2.0 / 9.0 * (error_a + 2.0 * error_b), rel=1e-5)


def test_degrees_of_freedom_are_those_of_what_limits():
    parts = [ingredient(1.0, 0.1, dof=4.0), ingredient(1.0, 1e-6, dof=500.0)]
    total = propagated(lambda values: float(values.sum()), parts, unit=ONE)
    assert total.dof == pytest.approx(4.0, rel=1e-6)
    assert total.ci95 == pytest.approx(Measured.student(2.0, 0.1, 4.0, ONE).ci95, rel=1e-6)


def test_exact_ingredients_leave_an_exact_figure():
    parts = [Ingredient(measured=Measured.exact(2.0, DN))]
    assert propagated(lambda values: float(values[0] ** 2), parts, unit=DN2) == Measured.exact(4.0, DN2)


def figure(model, dialect, quantity, unit):
    return next(
        one.row
        for one in translated(model)
        if one.dialect.startswith(dialect) and (one.row.quantity, one.row.measured.unit) == (quantity, unit)
    )


def test_errors_of_a_translation_match_a_monte_carlo():
    """Read noise, DSNU and system gain from three experiments: the spread of k_dark is its error."""
    truth = {SYSTEM_GAIN: (0.5, 0.002), READ_E2: (9.0, 0.05), DSNU_DN2: (0.25, 0.01)}
    units = {SYSTEM_GAIN: DN_PER_ELECTRON, READ_E2: ELECTRON2, DSNU_DN2: DN2}

    def model(values):
        given = {
            name: Ingredient(measured=Measured.normal(value, truth[name][1], units[name]))
            for name, value in values.items()
        }
        return GivenModel(given=given, conventions=Conventions(digital_maximum=4095.0))

    ours = figure(model({name: value for name, (value, _) in truth.items()}), "k's", "k_dark", ONE).measured
    rng = np.random.default_rng(5)
    repeats = 20_000
    gain, read, dsnu = (rng.normal(value, error, repeats) for value, error in truth.values())
    k_dark = np.sqrt(gain**2 * read + dsnu + 1.0 / 12.0) / 4095.0
    assert ours.std_error == pytest.approx(k_dark.std(), rel=4.0 / math.sqrt(2.0 * repeats))
    assert ours.ci95 is not None
    inside = np.mean((k_dark > ours.ci95[0]) & (k_dark < ours.ci95[1]))
    assert inside == pytest.approx(0.95, abs=4.0 * math.sqrt(0.95 * 0.05 / repeats))


def test_a_noise_below_rounding_is_zero_with_an_upper_limit():
    """METHOD 0: the interval lives in variance space; the signed variance stands beside it."""
    given = {
        K_DARK: Ingredient(measured=Measured.normal((0.27 / 1023.0) ** 2, 1e-8, ONE), fit="f"),
        K_SHOT: Ingredient(measured=Measured.normal(1e-4, 1e-7, ONE), fit="f"),
        K_FPN: Ingredient(measured=Measured.normal(-1e-6, 2e-6, ONE), fit="f"),
    }
    model = GivenModel(given=given, conventions=Conventions(digital_maximum=1023.0))
    noise = figure(model, "electrons", "read_noise", "e-")
    variance = figure(model, "electrons", "read_noise_variance", "e-^2").measured
    assert noise.measured.value == 0.0
    assert noise.measured.std_error is None
    assert {"upper-limit", "mixed", "quantization-limited"} == set(noise.flags)
    assert variance.value < 0.0
    assert noise.measured.ci95 == (0.0, pytest.approx(math.sqrt(variance.ci95[1])))
    assert figure(model, "k's", "k_fpn", ONE).measured.ci95 == (0.0, pytest.approx(math.sqrt(1.96 * 2e-6), rel=1e-4))
