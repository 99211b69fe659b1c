"""PATCHES.csv: what is read, and which sentence refuses the rest."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.errors import UsageError
from fullwell.frames.chart.patches import Patch, check_patches, inset, read_patches

HEADER = "patch,x,y,width,height,density\n"
ROWS = [f"{number},{20 * number},10,16,20,{0.1 * number:.2f}\n" for number in range(1, 7)]


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "PATCHES.csv"
    path.write_text(text, encoding="utf-8")
    return path


def with_row(row: str) -> str:
    return HEADER + "".join(ROWS[:4]) + row + "\n" + ROWS[5]


def test_reads_names_places_and_densities(tmp_path: Path) -> None:
    patches = read_patches(written(tmp_path, with_row(" grey , 100 ,10,16,20, ")))
    assert patches[0] == Patch(name="1", x=20, y=10, width=16, height=20, density=0.1)
    assert patches[4] == Patch(name="grey", x=100, y=10, width=16, height=20, density=None)


def test_density_may_be_left_out_and_a_byte_order_mark_left_in(tmp_path: Path) -> None:
    rows = [row.rsplit(",", 1)[0] for row in ROWS]
    patches = read_patches(written(tmp_path, "\ufeffpatch,x,y,width,height\r\n" + "\r\n\r\n".join(rows)))
    assert len(patches) == len(ROWS)
    assert {one.density for one in patches} == {None}


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("5,101,10,16,20,0.5", "line 6, column x: 101 is odd"),
        ("5,100,11,16,20,0.5", "line 6, column y: 11 is odd"),
        ("5,100,10,17,20,0.5", "line 6, column width: 17 is odd"),
        ("5,100,10,16,2.5,0.5", 'line 6, column height: "2.5" is not a whole number'),
        ("5,-100,10,16,20,0.5", "line 6, column x: -100 is negative"),
        ("5,100,10,16,4,0.5", "line 6, column height: 4 is too small"),
        ("5,100,10,16,20,dark", 'line 6, column density: "dark" is not a number'),
        ("5,100,10,16,20,nan", "line 6, column density: nan is not a density"),
        ("5,100,10,16,20,-0.1", "line 6, column density: -0.1 is not a density"),
        ("2,100,10,16,20,0.5", 'line 6, column patch: "2" stands in line 3'),
        (",100,10,16,20,0.5", "line 6, column patch: a patch needs a name"),
        ("5,100,10,16", "line 6 has 4 columns, the header has 6"),
        ("5,94,10,16,20,0.5", "lines 5 and 6: the patches 4 and 5 overlap"),
    ],
)
def test_refuses_with_line_and_column(tmp_path: Path, row: str, sentence: str) -> None:
    with pytest.raises(UsageError, match=r"PATCHES\.csv") as refused:
        read_patches(written(tmp_path, with_row(row)))
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "the first line must be"),
        ("name,x,y,w,h\n", "the first line must be"),
        (HEADER + "".join(ROWS[:4]), "4 patches are too few"),
    ],
)
def test_refuses_the_whole_file(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(UsageError, match=sentence):
        read_patches(written(tmp_path, text))


def test_refuses_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="Cannot read"):
        read_patches(tmp_path / "none.csv")
    path = tmp_path / "binary.csv"
    path.write_bytes(b"patch\xff\xfe")
    with pytest.raises(UsageError, match="not a CSV file"):
        read_patches(path)


def row_of_patches(**changes: int) -> list[Patch]:
    patches = [Patch(name=str(number), x=40 * number, y=0, width=32, height=32) for number in range(5)]
    changed = {"x": 160, "y": 0, "width": 32, "height": 32} | changes
    return [*patches[:4], Patch(name="last", **changed)]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"x": 170}, "reaches out of the visible mosaic, which has 200 x 40 pixels"),
        ({"y": 10}, "reaches out"),
        ({"x": -2}, "reaches out"),
        ({"x": 161, "width": 20}, "odd"),
        ({"width": 6}, "too small"),
        ({"x": 150}, "overlap"),
    ],
)
def test_checks_patches_against_the_frame(changes: dict[str, int], sentence: str) -> None:
    assert check_patches(row_of_patches(), width=200, height=40, cell=2) == ()
    with pytest.raises(UsageError, match=sentence):
        check_patches(row_of_patches(**changes), width=200, height=40, cell=2)


def test_small_patches_are_a_finding() -> None:
    findings = check_patches(row_of_patches(width=10, height=10), width=200, height=40, cell=2)
    assert [one.code for one in findings] == ["small-patches"]
    assert "(last)" in findings[0].message


@given(
    x=st.integers(0, 500).map(lambda one: 2 * one),
    width=st.integers(4, 300).map(lambda one: 2 * one),
    fraction=st.floats(0.0, 0.45),
)
def test_insets_are_even_and_leave_out_what_they_say(x: int, width: int, fraction: float) -> None:
    (one,) = inset([Patch(name="a", x=x, y=x, width=width, height=width, density=0.3)], fraction)
    assert one.x % 2 == one.width % 2 == 0
    assert (one.y, one.height, one.density) == (one.x, one.width, 0.3)
    assert -1e-6 <= (one.x - x) - fraction * width < 2 + 1e-6
    if one.width:
        assert -1e-6 <= (x + width - one.x - one.width) - fraction * width < 2 + 1e-6
