"""A frame that a study holds twice counts once, whoever holds the copy and however many threads read it."""

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile

from fullwell.findings import Severity
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.raw.image import RawHeader
from fullwell.report.document import results_json
from fullwell.workflow import duplicates
from fullwell.workflow.characterize import measure
from fullwell.workflow.duplicates import reduce_without_copies
from fullwell.workflow.options import Options

SERIES = (("flat", 1000, 500.0), ("flat", 2000, 900.0), ("dark", 1000, 20.0))
Rewrite = Callable[[Path], None]


def write(path: Path, mosaic: np.ndarray) -> None:
    tifffile.imwrite(path, mosaic.astype(np.uint16), photometric="minisblack", metadata=None)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return three series of seven mono frames."""
    rng = np.random.default_rng(11)
    root = tmp_path / "study"
    for kind, exposure_us, level in SERIES:
        (root / kind).mkdir(parents=True, exist_ok=True)
        for n in range(7):
            write(root / kind / f"exp{exposure_us}us_{n}.tif", rng.normal(level, 5.0, (40, 48)).round())
    return root


def results_of(folder: Path, *, workers: int, reverse: bool = False) -> str:
    study = load_study(folder, Selection(cfa="mono"))
    if reverse:
        backwards = tuple(dataclasses.replace(one, frames=one.frames[::-1]) for one in study.series)
        study = dataclasses.replace(study, series=backwards)
    found = reduce_without_copies(study, workers=workers, tile=16)
    return repr((found.statistics, found.hashes, found.excluded, found.findings))


def copy_some(folder: Path) -> None:
    """Put copies into the first burst, behind it, and into another series."""
    shutil.copy(folder / "flat/exp1000us_1.tif", folder / "flat/exp1000us_3.tif")
    shutil.copy(folder / "flat/exp1000us_1.tif", folder / "flat/exp1000us_6.tif")
    shutil.copy(folder / "dark/exp1000us_0.tif", folder / "flat/exp2000us_2.tif")


def test_copies_are_left_out_as_if_they_had_never_been_there(folder: Path) -> None:
    copy_some(folder)
    results = measure(folder, options=Options(selection=Selection(cfa="mono"), workers=2)).results
    excluded = {one["path"]: one["reason"] for one in results.study["excluded"]}  # type: ignore[attr-defined]
    assert excluded == {
        "flat/exp1000us_3.tif": "its content is that of flat/exp1000us_1.tif",
        "flat/exp1000us_6.tif": "its content is that of flat/exp1000us_1.tif",
        "flat/exp2000us_2.tif": "its content is that of dark/exp1000us_0.tif",
    }
    (finding,) = [one for one in results.findings if one.code == "duplicate-frame"]
    assert finding.severity is Severity.ERROR
    assert finding.files == tuple(excluded)
    assert "flat/exp1000us_3.tif (the same as flat/exp1000us_1.tif)" in finding.message
    for name in excluded:
        (folder / name).unlink()
    clean = measure(folder, options=Options(selection=Selection(cfa="mono"), workers=2)).results
    assert results.rows == clean.rows
    assert results.curves == clean.curves


def test_kept_sums_leave_copies_out(folder: Path) -> None:
    copy_some(folder)
    study = load_study(folder, Selection(cfa="mono"))
    kept = {Kind.FLAT, Kind.DARK}
    found = reduce_without_copies(study, workers=2, tile=16, keep=kept)
    assert list(found.sums) == [series.key for series in study.series]
    for name in ("flat/exp1000us_3.tif", "flat/exp1000us_6.tif", "flat/exp2000us_2.tif"):
        (folder / name).unlink()
    for series in load_study(folder, Selection(cfa="mono")).series:
        frames = [tifffile.imread(folder / frame.name).astype(np.uint32) for frame in series.frames]
        assert len(frames) == len(found.statistics[series.key].frames)
        np.testing.assert_array_equal(found.sums[series.key], np.sum(frames, axis=0))


@pytest.mark.parametrize("workers", [2, 7])
def test_neither_threads_nor_the_order_of_files_matter(folder: Path, workers: int) -> None:
    copy_some(folder)
    reference = results_of(folder, workers=1)
    assert results_of(folder, workers=workers) == reference
    assert results_of(folder, workers=workers, reverse=True) == reference


def test_a_series_of_nothing_but_copies_is_gone(folder: Path) -> None:
    for n in range(7):
        shutil.copy(folder / f"dark/exp1000us_{n}.tif", folder / f"flat/exp1000us_{n}.tif")
    measured = measure(folder, options=Options(selection=Selection(cfa="mono"), workers=1))
    assert [burst.exposure_s for group in measured.groups for burst in group.flats] == [0.002]
    assert len(measured.results.study["excluded"]) == 7  # type: ignore[arg-type]


def test_damaged_copies_are_named_for_their_damage(folder: Path) -> None:
    for n in (2, 3):
        (folder / f"flat/exp1000us_{n}.tif").write_bytes((folder / "flat/exp1000us_1.tif").read_bytes()[:-200])
    study = load_study(folder, Selection(cfa="mono"))
    found = reduce_without_copies(study, workers=2, tile=16)
    left_out = (*study.excluded, *found.excluded)
    assert {one.name for one in left_out} == {"flat/exp1000us_2.tif", "flat/exp1000us_3.tif"}
    assert "duplicate-frame" not in {one.code for one in left_out}


def test_frames_of_one_code_count_with_a_warning(folder: Path) -> None:
    for n in (0, 1):
        write(folder / f"dark/exp1000us_{n}.tif", np.full((40, 48), 16))
    study = load_study(folder, Selection(cfa="mono"))
    found = reduce_without_copies(study, workers=2, tile=16)
    assert found.excluded == ()
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("identical-frames", Severity.WARNING)
    assert finding.files == ("dark/exp1000us_0.tif", "dark/exp1000us_1.tif")
    assert len(found.statistics["dark", 0.0, 0.001].frames) == 7


def test_an_original_that_is_gone_by_now_may_have_copies(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy_some(folder)

    def gone(header: RawHeader) -> memoryview:
        raise FileNotFoundError(header.path)

    monkeypatch.setattr(duplicates, "read_bytes", gone)
    found = reduce_without_copies(load_study(folder, Selection(cfa="mono")), workers=2, tile=16)
    assert {one.code for one in found.excluded} == {"duplicate-frame"}
    assert len(found.excluded) == 3


def test_the_document_is_the_same_bytes_for_any_number_of_workers(folder: Path) -> None:
    copy_some(folder)
    options = [Options(selection=Selection(cfa="mono"), workers=workers) for workers in (1, 7)]
    one, seven = (results_json(measure(folder, options=option).results) for option in options)
    assert one == seven
