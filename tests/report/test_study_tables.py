"""The published study's tables as files: names, numbers that read back, and what stays empty."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from fullwell.fit.legacy.dark import StudyDarkLine
from fullwell.fit.legacy.read_noise import ReadNoiseRepeats
from fullwell.fit.legacy.regions import study_regions
from fullwell.fit.legacy.response import StudyResponse, study_response
from fullwell.fit.legacy.shading_map import fit_legacy_map
from fullwell.fit.legacy.volts import VoltScale
from fullwell.report.study_tables import (
    ShadingCoefficients,
    StudyTables,
    write_iso_tables,
    write_matrix,
    write_study_tables,
)

SIZE = (126, 168)
VOLTS = VoltScale(swing_v=0.45907, bit_depth=10, white_level=1023.0)


def response(cfa: str, *, iso: float | None = 55.0) -> StudyResponse:
    rng = np.random.default_rng(3)
    sums = [rng.poisson(level, SIZE).astype(np.uint32) for level in (1000, 2000)]
    base = fit_legacy_map(sums[0], 4, cfa=cfa)
    return study_response(
        sums, (4, 4), (0.01, 0.02), iso=iso, cfa=cfa, base=base, regions=study_regions(*SIZE), black_dn=None
    )


def tables() -> StudyTables:
    surface = fit_legacy_map(np.random.default_rng(4).poisson(900, SIZE).astype(np.uint32), 3, cfa="mono").surfaces[0]
    return StudyTables(
        coefficients=(ShadingCoefficients(iso=55.0, exposure_s=0.001, channel="mono", surface=surface),),
        read_noise=(
            ReadNoiseRepeats(iso=55.0, frames=("a", "b"), flow1_dn=np.array([1.5, 1.6]), flow2_dn=np.array([1.1, 1.2])),
        ),
        dark_lines=(StudyDarkLine(iso=None, channel="all", slope_dn_per_s=0.0625, intercept_dn=64.5),),
        volts=VOLTS,
        base_iso=55.0,
        base_exposure_s=0.001,
    )


def test_numbers_read_back_to_twelve_digits(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    values = rng.normal(size=(40, 7000)) * 10.0 ** rng.integers(-12, 12, (40, 7000))
    write_matrix(tmp_path / "values.csv", values)
    text = (tmp_path / "values.csv").read_text()
    read = np.array([[float(cell) for cell in line.split(",")] for line in text.splitlines()])
    np.testing.assert_allclose(read, values, rtol=5.01e-12, atol=0.0)


def test_a_strided_plane_is_written_row_by_row(tmp_path: Path) -> None:
    whole = np.arange(24.0).reshape(4, 6)
    write_matrix(tmp_path / "plane.csv", whole[1::2, ::2])
    lines = (tmp_path / "plane.csv").read_text().splitlines()
    assert [[float(cell) for cell in line.split(",")] for line in lines] == [[6.0, 8.0, 10.0], [18.0, 20.0, 22.0]]


def test_the_same_files_for_any_number_of_threads(tmp_path: Path) -> None:
    for workers in (1, 3):
        write_iso_tables(response("BGGR"), tmp_path / str(workers), workers=workers)
    one, three = (
        {path.name: path.read_bytes() for path in (tmp_path / name / "iso_55").iterdir()} for name in ("1", "3")
    )
    assert len(one) == 8 + 16 * 8 + 8
    assert one == three


def test_a_mono_sensor_has_no_tables_by_colour(tmp_path: Path) -> None:
    write_iso_tables(response("mono", iso=None), tmp_path)
    names = {path.name for path in (tmp_path / "iso_unknown").iterdir()}
    assert len(names) == 2 + 16 * 2 + 8
    assert {"px_resp_all_px.csv", "patch_16darkv_all_px.csv"} <= names
    assert "px_resp_r.csv" not in names
    assert len((tmp_path / "iso_unknown" / "PRNU1288_patches.csv").read_text().splitlines()) == 16


def test_cells_in_volts_are_as_published(tmp_path: Path) -> None:
    write_study_tables(tables(), tmp_path)
    _, first, _ = (tmp_path / "read_noise.csv").read_text().splitlines()
    assert first.split(",")[:4] == ["55", "1", "1.5", "1.1"]
    assert float(first.split(",")[4]) == 1.1 * (0.4591 / 1024)
    _, line = (tmp_path / "dark_current.csv").read_text().splitlines()
    assert line.split(",")[:4] == ["", "all", "0.0625", "64.5"]
    assert float(line.split(",")[4]) == 0.0625 * 0.459 / 1023


def test_cells_in_volts_are_empty_without_a_swing(tmp_path: Path) -> None:
    write_study_tables(dataclasses.replace(tables(), volts=None), tmp_path)
    assert all(line.endswith(",") for line in (tmp_path / "read_noise.csv").read_text().splitlines()[1:])
    assert all(line.endswith(",") for line in (tmp_path / "dark_current.csv").read_text().splitlines()[1:])
    assert "voltage swing is unknown" in (tmp_path / "README.txt").read_text()


def test_a_table_without_rows_is_not_written(tmp_path: Path) -> None:
    write_study_tables(dataclasses.replace(tables(), read_noise=(), coefficients=(), base_exposure_s=None), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["README.txt", "dark_current.csv"]
    assert "imcrop" not in (tmp_path / "README.txt").read_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, "left in, as published"),
        ({"black_subtracted": True}, "not as published"),
        ({"scaled": True}, "scaled down to the size of these frames"),
    ],
)
def test_the_readme_says_what_differs_from_the_study(tmp_path: Path, change: dict[str, bool], words: str) -> None:
    write_study_tables(dataclasses.replace(tables(), **change), tmp_path)
    assert words in (tmp_path / "README.txt").read_text()
