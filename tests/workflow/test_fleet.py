"""Many studies become one table; a study that cannot be measured is a line in it and costs the others nothing."""

import csv
import errno
import json
import os
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from mixed_study import write_frame

from fullwell.errors import UsageError
from fullwell.workflow import fleet
from fullwell.workflow.characterize import characterize
from fullwell.workflow.fleet import Entry, Job, characterize_fleet, measure_one, named
from fullwell.workflow.options import CacheChoice, Options


def write_study(root: Path, seed: int) -> Path:
    rng = np.random.default_rng(seed)
    for folder, level in (("flat/exp10ms", 300), ("dark/exp10ms", 64)):
        (root / folder).mkdir(parents=True)
        for number in range(3):
            mosaic = rng.normal(level, 4, (64, 96)).round().clip(0, 1023).astype(np.uint16)
            write_frame(root / folder / f"{number}.dng", mosaic, 2 * number % 4 + 1)
    return root


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = tmp_path_factory.mktemp("fleet")
    (root / "empty").mkdir()
    return [write_study(root / "a" / "raw", 1), write_study(root / "b" / "raw", 2), root / "empty"]


def document(folder: Path) -> dict[str, object]:
    found = json.loads((folder / "results.json").read_text())
    del found["run"]
    return found


def seen(entries: tuple[Entry, ...]) -> list[tuple[str, str]]:
    return [(entry.name, entry.state) for entry in entries]


def test_a_fleet_is_its_studies(studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, lines = tmp_path / "out", []
    found = characterize_fleet(
        studies, out, options=Options(workers=2, cache=CacheChoice(folder=tmp_path / "any")), told=lines.append
    )
    assert seen(found) == [("a-raw", "done"), ("b-raw", "done"), ("empty", "failed")]
    assert sorted(seen(tuple(lines))) == seen(found)
    assert "is empty" in found[2].reason
    characterize(studies[1], tmp_path / "alone", options=Options(workers=1))
    assert document(out / "b-raw") == document(tmp_path / "alone")
    assert (out / "b-raw.cache").is_dir()
    with (out / "fleet.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    table = pq.read_table(out / "fleet.parquet").to_pylist()
    assert [row["study"] for row in table] == [row["study"] for row in rows]
    for name in ("a-raw", "b-raw"):
        own = [row["quantity"] for row in document(out / name)["results"]]
        assert [row["quantity"] for row in rows if row["study"] == name] == own
    index = json.loads((out / "fleet.json").read_text())
    assert [one["name"] for one in index["studies"]] == ["a-raw", "b-raw", "empty"]

    def never(*_: object, **__: object) -> None:
        raise AssertionError("results that are there are kept")

    monkeypatch.setattr(fleet, "characterize", never)
    again = characterize_fleet(studies[:2], out, options=Options(), resume=True)
    assert seen(again) == [("a-raw", "kept"), ("b-raw", "kept")]
    assert pq.read_table(out / "fleet.parquet").to_pylist() == table


def test_results_of_another_study_are_not_taken_for_its_own(
    studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "out"
    (done,) = characterize_fleet(studies[:1], root, options=Options())
    measured = document(root / "raw")
    for resume in (True, False):
        (other,) = characterize_fleet(studies[1:2], root, options=Options(), resume=resume)
        assert other.state == "failed"
        assert f"results of another study, {studies[0]}" in other.reason
        assert document(root / "raw") == measured
    monkeypatch.chdir(studies[0].parent)
    (kept,) = characterize_fleet([Path("raw")], root, options=Options(), resume=True)
    assert (kept.state, kept.errors, kept.warnings) == ("kept", done.errors, done.warnings)
    assert done.warnings > 0


def test_results_measured_by_hand_from_where_the_study_lies_are_kept(
    studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(studies[0].parent)
    characterize(Path("raw"), tmp_path / "raw", options=Options())
    (kept,) = characterize_fleet([Path("raw")], tmp_path, options=Options(), resume=True)
    assert kept.state == "kept"


def test_a_defect_costs_one_study(studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(fleet, "characterize", broken)
    job = Job(name="a", study=studies[0], out=tmp_path / "a", options=Options(), resume=False)
    entry = measure_one(job)
    assert entry.state == "failed"
    assert "ZeroDivisionError" in entry.reason


def test_a_full_disk_is_no_defect(studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "a"))

    monkeypatch.setattr(fleet, "characterize", full)
    entry = measure_one(Job(name="a", study=studies[0], out=tmp_path / "a", options=Options(), resume=False))
    assert entry.reason == f"The system refused {tmp_path / 'a'}: {os.strerror(errno.ENOSPC)}."


def test_what_was_measured_before_an_interruption_is_kept(
    studies: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def interrupted(study: Path, out: Path, *, options: Options) -> object:
        asked.append(study)
        if study == studies[1]:
            raise KeyboardInterrupt
        return characterize(study, out, options=options)

    def states() -> list[tuple[str, str]]:
        return [(one["name"], one["state"]) for one in json.loads((tmp_path / "fleet.json").read_text())["studies"]]

    def in_table() -> set[str]:
        return set(pq.read_table(tmp_path / "fleet.parquet").column("study").to_pylist())

    monkeypatch.setattr(fleet, "characterize", interrupted)
    with pytest.raises(KeyboardInterrupt, match=r"1 of 3 studies measured.*--resume"):
        characterize_fleet(studies, tmp_path, options=Options(workers=1, cache=CacheChoice(folder=tmp_path / "any")))
    assert states() == [("a-raw", "done"), ("b-raw", "interrupted"), ("empty", "interrupted")]
    assert in_table() == {"a-raw"}
    monkeypatch.setattr(fleet, "characterize", characterize)
    characterize_fleet(studies, tmp_path, options=Options(workers=1), resume=True)
    assert states() == [("a-raw", "kept"), ("b-raw", "done"), ("empty", "failed")]
    monkeypatch.setattr(fleet, "characterize", interrupted)
    with pytest.raises(KeyboardInterrupt, match="2 of 3"):
        characterize_fleet(studies[::-1], tmp_path, options=Options(workers=1))
    assert states() == [("a-raw", "kept"), ("b-raw", "kept"), ("empty", "failed")]
    assert in_table() == {"a-raw", "b-raw"}
    assert asked == [studies[0], studies[1], studies[2], studies[1]]


def test_names_tell_studies_apart(tmp_path: Path) -> None:
    paths = [tmp_path / "a" / "study.toml", tmp_path / "b" / "study.toml", tmp_path / "b" / "dark.toml", tmp_path / "c"]
    assert named(paths) == dict(zip(["a", "b", "dark", "c"], paths, strict=True))
    with pytest.raises(UsageError, match="cannot be told"):
        named([tmp_path / "b", tmp_path / "b" / "study.toml"])


def test_a_fleet_needs_studies_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="at least one"):
        characterize_fleet([], tmp_path, options=Options())
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="one of the studies"):
        characterize_fleet([tmp_path / "a", tmp_path], tmp_path / "a" / ".." / "a", options=Options())
    assert not (tmp_path / "a").exists()
    (tmp_path / "fleet.parquet").write_bytes(b"of an earlier run")
    characterize_fleet([tmp_path / "nothing"], tmp_path, options=Options())
    assert not (tmp_path / "fleet.parquet").exists()
    with pytest.raises(UsageError, match="is a file"):
        characterize_fleet([tmp_path], tmp_path / "file", options=Options())


def test_a_cluster_measures_whole_studies(studies: list[Path], tmp_path: Path) -> None:
    options = Options(workers=1, dask="local", cache=None)
    found = characterize_fleet(studies[1:], tmp_path / "out", options=options)
    assert seen(found) == [("empty", "failed"), ("raw", "done")]
    characterize(studies[1], tmp_path / "alone", options=Options(workers=2))
    assert document(tmp_path / "out" / "raw") == document(tmp_path / "alone")
