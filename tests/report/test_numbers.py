"""Numbers are printed to what their uncertainty allows, and read back to within it."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fullwell.report.numbers import show, show_exposure, show_interval, show_iso, show_plain, show_unit
from fullwell.units import Measured

MAGNITUDES = st.floats(min_value=1e-12, max_value=1e12)
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (2.34567, 0.0123, "2.346 ± 0.012"),
        (2.34567, 0.0996, "2.35 ± 0.10"),
        (-0.00123, 0.0456, "−0.001 ± 0.046"),
        (-0.0001, 0.0456, "0.000 ± 0.046"),
        (29724.0, 312.0, "29\u202f720 ± 310"),
        (5832.7, 41.2, "5833 ± 41"),
        (63.99621, 0.003, "63.9962 ± 0.0030"),
        (0.0, 0.021, "0.000 ± 0.021"),
        (1.2346e-7, 3.21e-9, "(1.235 ± 0.032) × 10⁻⁷"),
        (4.5e8, 1.2e6, "(4.500 ± 0.012) × 10⁸"),
    ],
)
def test_value_and_error(value, error, text):
    assert show(Measured.normal(value, error, "DN")) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1023.0, "1023"),
        (65535.0, "65\u202f535"),
        (0.17049, "0.1705"),
        (0.5, "0.5000"),
        (29.9, "29.90"),
        (math.nan, "—"),
        (0.0, "0"),
    ],
)
def test_a_value_without_error(value, text):
    assert show(Measured.exact(value, "DN")) == text


def test_limits():
    assert show(Measured(value=0.0, unit="DN", ci95=(0.0, 0.1234)), ("upper-limit",)) == "≤ 0.12 (95 %)"
    assert show(Measured(value=1.04, unit="%", ci95=(0.0, 1.04)), ("upper-limit",)) == "≤ 1.04 (95 %)"
    assert show(Measured.normal(5832.7, 41.2, "e-"), ("adc-limited", "lower-bound")) == "≥ 5833"


def test_interval_has_the_digits_of_the_error():
    assert show_interval(Measured.normal(2.34567, 0.0123, "DN")) == "2.322 to 2.370"
    assert show_interval(Measured.exact(1.0, "DN")) == "—"


def test_units_exposures_and_isos():
    assert [show_unit(unit) for unit in ("DN^2", "DN/e-", "e-^2", "e-/s", "1", "%", "e-/um^2")] == [
        "DN²",
        "DN/e⁻",
        "(e⁻)²",
        "e⁻/s",
        "",
        "%",
        "e⁻/µm²",
    ]
    assert [show_exposure(one) for one in (2.0, 0.16, 0.002867, 2.5e-5, 0.0, None)] == [
        "2 s",
        "160 ms",
        "2.867 ms",
        "25 µs",
        "0 s",
        "—",
    ]
    assert (show_iso(None), show_iso(55.0)) == ("unknown ISO", "ISO 55")
    assert show_plain(None) == "—"


def read_back(text: str) -> tuple[float, float]:
    body, _, power = text.partition(" × 10")
    scale = 10.0 ** int(power.translate(SUPERSCRIPTS)) if power else 1.0
    value, error = body.strip("()").replace("\u202f", "").replace("−", "-").split(" ± ")
    return float(value) * scale, float(error) * scale


@given(value=MAGNITUDES, sign=st.sampled_from((-1.0, 1.0)), relative=st.floats(min_value=1e-8, max_value=1e3))
def test_what_is_printed_lies_within_a_twentieth_of_the_error(value, sign, relative):
    # two significant digits of the error: its unit in the last place is at most a tenth of it, rounding half of that
    error = value * relative
    assume(1e-14 < error < 1e14)
    shown_value, shown_error = read_back(show(Measured.normal(sign * value, error, "DN")))
    slack = 1e-12 * max(value, error)
    assert abs(shown_value - sign * value) <= 0.0501 * error + slack
    assert abs(shown_error - error) <= 0.0501 * error + slack


@given(value=MAGNITUDES)
def test_a_number_without_error_keeps_four_digits(value):
    text = show_plain(value)
    mantissa, _, power = text.partition(" × 10")
    scale = 10.0 ** int(power.translate(SUPERSCRIPTS)) if power else 1.0
    assert float(mantissa.replace("\u202f", "")) * scale == pytest.approx(value, rel=5.1e-4)
