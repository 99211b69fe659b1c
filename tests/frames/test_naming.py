"""ISO and exposure from names."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.frames.naming import exposure_in_name, exposure_in_path, iso_in_name, iso_in_path

WORDS = st.text(alphabet=st.characters(codec="ascii", categories=("Ll", "Lu", "Nd")), max_size=5)


@given(WORDS, st.integers(1, 10**7), st.sampled_from(["ISO_{}", "iso_{}", "Iso-{}"]))
def test_an_iso_is_found_whatever_stands_around_it(around: str, iso: int, pattern: str) -> None:
    assert iso_in_name(f"{around}_{pattern.format(iso)}_frame") == iso


@given(st.integers(1, 10**9), st.integers(0, 12), st.sampled_from([("us", 10**6), ("ms", 10**3), ("s", 1)]))
def test_an_exposure_is_the_nearest_float_to_what_the_name_says(n: int, zeros: int, unit: tuple[str, int]) -> None:
    assert exposure_in_name(f"exp{'0' * zeros}{n}{unit[0]}_n03.tiff") == n / unit[1]


@pytest.mark.parametrize(
    ("name", "seconds"), [("exp0.5s", 0.5), ("EXP_12.5ms", 0.0125), ("expo5us", None), ("export", None), ("exp5", None)]
)
def test_decimals_and_near_misses(name: str, seconds: float | None) -> None:
    assert exposure_in_name(name) == seconds


@pytest.mark.parametrize("name", ["isolated_5", "ISO_", "ISO_0", "unisono_5"])
def test_what_is_no_iso(name: str) -> None:
    assert iso_in_name(name) is None


def test_a_zero_exposure_is_unknown() -> None:
    assert exposure_in_name("exp000us") is None


def test_the_innermost_name_wins() -> None:
    assert exposure_in_path("flat/exp10ms/ISO_100/exp20ms_n1.tif") == 0.02
    assert iso_in_path("flat/ISO_100/exp20ms_n1.tif") == 100.0
    assert iso_in_path("flat/a.tif") is None
