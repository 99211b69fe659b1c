"""The kind of a frame by its folder's name: the table of RESULTS 1."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.frames.role import kind_of_folder
from fullwell.frames.series import Kind

TABLE = [
    ("dark", Kind.DARK),
    ("darks_20C", Kind.DARK),
    ("flatdark", Kind.DARK),
    ("Flat-Dark frames", Kind.DARK),
    ("DarkCurrentRate", Kind.DARK),
    ("bias", Kind.BIAS),
    ("ReadNoise", Kind.BIAS),
    ("read_noise_run2", Kind.BIAS),
    ("flat", Kind.FLAT),
    ("Flats", Kind.FLAT),
    ("PRNU_DSNU", Kind.FLAT),
    ("bright", Kind.FLAT),
    ("light-1", Kind.FLAT),
    ("chart", Kind.CHART),
    ("Chart shots", Kind.CHART),
    ("scene", Kind.SCENE),
    ("Interesting", Kind.SCENE),
]


@pytest.mark.parametrize(("name", "kind"), TABLE)
def test_every_name_of_the_contract(name: str, kind: Kind) -> None:
    assert kind_of_folder(name) is kind


@pytest.mark.parametrize("name", ["notes", "interesting_ones", "mydark", "ISO_100", "", "__"])
def test_other_names_tell_nothing(name: str) -> None:
    assert kind_of_folder(name) is None


@given(
    st.sampled_from(TABLE),
    st.lists(st.sampled_from(["_", "-", " ", ""]), min_size=30, max_size=30),
    st.lists(st.booleans(), min_size=30, max_size=30),
)
def test_case_and_blanks_never_matter(row: tuple[str, Kind], blanks: list[str], upper: list[bool]) -> None:
    name, kind = row
    spelled = "".join(
        blank + (letter.upper() if up else letter.lower())
        for letter, blank, up in zip(name, blanks, upper, strict=False)
    )
    assert kind_of_folder(spelled) is kind
