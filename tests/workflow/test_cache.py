"""Finished series are found again where nothing has changed, and never believed where something has."""

import dataclasses
import json
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mixed_study import TILE, assert_same_reduction, mixed_study

from fullwell.cli.parsing import cache_from
from fullwell.errors import UnreadableFileError, UsageError
from fullwell.frames.series import Frame, Kind, Study
from fullwell.raw.isolation import GAVE_UP
from fullwell.workflow.cache import fingerprint, series_cache
from fullwell.workflow.cache.opening import cache_beside, opened_cache
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.options import CacheChoice, Options
from fullwell.workflow.reduce import Reduction, reduce_study
from fullwell.workflow.slots import Slots, Told, hash_of

KEPT = (Kind.FLAT, Kind.DARK)


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Study:
    """A study whose files count as old enough for their times to tell of every change."""
    monkeypatch.setattr(fingerprint, "TICK_NS", 0)
    (tmp_path / "study").mkdir()
    return mixed_study(tmp_path / "study")[0]


@pytest.fixture
def decoded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of all files that are read for their pixels."""
    names: list[str] = []
    original = Slots.read

    def read(self: Slots, frame: Frame, told: Told, *, whole: bool = False, two: bool = False) -> None:
        names.append(frame.name)
        original(self, frame, told, whole=whole, two=two)

    monkeypatch.setattr(Slots, "read", read)
    return names


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out.cache"


def reduced(study: Study, folder: Path | None, *, tile: int = TILE, recheck: bool = False) -> Reduction:
    cache = None if folder is None else SeriesCache(folder, recheck=recheck)
    found = reduce_study(study, workers=2, tile=tile, keep=KEPT, cache=cache)
    if cache is not None:
        cache.sweep()
    return found


def assert_equal(found: Reduction, fresh: Reduction) -> None:
    assert_same_reduction(found, fresh)
    assert list(found.sums) == list(fresh.sums)
    for one, other in zip(found.sums.values(), fresh.sums.values(), strict=True):
        np.testing.assert_array_equal(one, other)
        assert not one.flags.writeable


def test_a_second_run_decodes_nothing(study: Study, folder: Path, decoded: list[str]) -> None:
    fresh = reduced(study, None)
    assert_equal(reduced(study, folder), fresh)
    decoded.clear()
    assert_equal(reduced(study, folder), fresh)
    assert not decoded


def test_what_was_found_is_the_same_with_damaged_frames(study: Study, folder: Path, decoded: list[str]) -> None:
    cut = study.root / "flat-0.02-02.dng"
    cut.write_bytes(cut.read_bytes()[:-200])
    fresh = reduced(study, None)
    assert [one.name for one in fresh.excluded] == [cut.name]
    reduced(study, folder)
    decoded.clear()
    assert_equal(reduced(study, folder), fresh)
    assert not decoded


def test_only_what_was_added_is_read(study: Study, folder: Path, decoded: list[str]) -> None:
    part = dataclasses.replace(study, series=study.series[1:])
    reduced(part, folder)
    decoded.clear()
    assert_equal(reduced(study, folder), reduced(study, None))
    first = sorted(frame.name for frame in study.series[0].frames)
    assert sorted(decoded[: len(first)]) == first


def test_a_copied_study_is_known_by_its_content(study: Study, folder: Path, decoded: list[str], tmp_path: Path) -> None:
    fresh = reduced(study, folder)
    shutil.copytree(study.root, tmp_path / "copy")
    moved = dataclasses.replace(
        study,
        root=tmp_path / "copy",
        series=tuple(
            dataclasses.replace(
                one,
                frames=tuple(
                    dataclasses.replace(
                        frame, header=dataclasses.replace(frame.header, path=tmp_path / "copy" / frame.name)
                    )
                    for frame in one.frames
                ),
            )
            for one in study.series
        ),
    )
    decoded.clear()
    assert_equal(reduced(moved, folder), fresh)
    assert not decoded


def other_content(frame: Frame) -> None:
    """Change one code of a file; its size and times stay."""
    path, before = frame.header.path, frame.header.path.stat()
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def test_a_changed_file_is_read_again(study: Study, folder: Path) -> None:
    fresh = reduced(study, folder)
    other_content(study.series[0].frames[0])
    changed = reduced(study, folder)
    assert_equal(changed, reduced(study, None))
    assert changed.hashes != fresh.hashes


def test_files_changed_lately_are_hashed_again(
    study: Study, folder: Path, decoded: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fingerprint, "TICK_NS", 3600 * 10**9)
    monkeypatch.setattr(series_cache, "fingerprint", lambda path: None if fingerprint.fingerprint(path) is None else "")
    reduced(study, folder)
    decoded.clear()
    reduced(study, folder)
    assert not decoded, "the same content is known by its hash"
    other_content(study.series[0].frames[0])
    assert_equal(reduced(study, folder), reduced(study, None))


def test_recheck_believes_no_file_system(study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(series_cache, "fingerprint", lambda _: "never changes")
    stale = reduced(study, folder)
    other_content(study.series[0].frames[0])
    assert reduced(study, folder).hashes == stale.hashes
    assert_equal(reduced(study, folder, recheck=True), reduced(study, None))


def test_other_settings_make_other_numbers(study: Study, folder: Path) -> None:
    reduced(study, folder)
    assert_equal(reduced(study, folder, tile=2 * TILE), reduced(study, None, tile=2 * TILE))


def flipped(place: float) -> Callable[[Path], None]:
    def damage(path: Path) -> None:
        content = bytearray(path.read_bytes())
        content[int(place * (len(content) - 1))] ^= 4
        path.write_bytes(content)

    return damage


DAMAGES = {
    "front": flipped(0.0),
    "checksum": flipped(0.0008),
    "structure": flipped(0.01),
    "numbers": flipped(0.4),
    "end": flipped(1.0),
    "cut": lambda path: path.write_bytes(path.read_bytes()[:-1]),
    "emptied": lambda path: path.write_bytes(b""),
    "gone": Path.unlink,
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("suffix", [".series", ".json"])
def test_a_damaged_cache_is_rebuilt(study: Study, folder: Path, damage: Callable[[Path], None], suffix: str) -> None:
    fresh = reduced(study, folder)
    whole = {path.name for path in folder.iterdir()}
    for path in folder.glob(f"*{suffix}"):
        damage(path)
    assert_equal(reduced(study, folder), fresh)
    assert {path.name for path in folder.iterdir()} == whole
    cache = SeriesCache(folder)
    reduce_study(study, workers=1, tile=TILE, keep=KEPT, cache=cache)
    assert (cache.found, cache.damaged) == (len(study.series), 0)


@pytest.mark.parametrize(
    "changes", [{"hashes": [1]}, {"prints": None}, {"prints": [3]}, {"recipe": 1}, {"key": 3}, {"more": 1}]
)
def test_an_index_of_another_shape_is_as_good_as_none(study: Study, folder: Path, changes: dict[str, object]) -> None:
    fresh = reduced(study, folder)
    for path in folder.glob("*.json"):
        path.write_text(json.dumps(json.loads(path.read_text()) | changes))
    assert_equal(reduced(study, folder), fresh)


def test_entries_that_change_places_are_noticed(study: Study, folder: Path) -> None:
    fresh = reduced(study, folder)
    one, other, *_ = sorted(folder.glob("*.series"))
    content = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(content)
    assert_equal(reduced(study, folder), fresh)


def test_a_full_disk_costs_the_cache_and_nothing_else(
    study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(series_cache, "write_packed", full)
    assert_equal(reduced(study, folder), reduced(study, None))
    assert not list(folder.glob("*.part"))


def test_a_series_with_an_unreadable_file_is_not_kept(study: Study, folder: Path) -> None:
    (study.root / "flat-0.02-06.dng").unlink()
    fresh = reduced(study, folder)
    assert len(list(folder.glob("*.series"))) == len(study.series) - 1
    assert_equal(reduced(study, folder), fresh)


def test_a_series_whose_decoder_gave_up_is_read_again(
    study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may have been the machine: a decoder that ran out of memory, or that somebody ended."""
    lost, read = "flat-0.02-06.dng", Slots.read

    def fail(self: Slots, frame: Frame, told: Told, *, whole: bool = False, two: bool = False) -> None:
        read(self, frame, told, whole=whole, two=two)
        if frame.name == lost:
            told(frame, hash_of(frame.header))
            raise UnreadableFileError(GAVE_UP, "the decoder gave up")

    with monkeypatch.context() as failing:
        failing.setattr(Slots, "read", fail)
        assert [one.name for one in reduced(study, folder).excluded] == [lost]
    assert_equal(reduced(study, folder), reduced(study, None))


def test_what_is_not_used_is_removed(study: Study, folder: Path) -> None:
    reduced(study, folder)
    foreign = folder / "notes.txt"
    foreign.write_text("mine")
    fresh, left = folder / "new.part", folder / "old.part"
    for part in (fresh, left):
        part.write_bytes(b"half")
    long_ago = time.time() - 7200
    os.utime(left, (long_ago, long_ago))
    reduced(dataclasses.replace(study, series=study.series[:1]), folder)
    assert len(list(folder.glob("*.series"))) == len(list(folder.glob("*.json"))) == 1
    assert foreign.exists()
    assert fresh.exists()
    assert not left.exists()


def test_a_shared_cache_keeps_what_fits(study: Study, folder: Path) -> None:
    reduced(study, folder)
    sizes = sorted(path.stat().st_size for path in folder.glob("*.series"))
    one = dataclasses.replace(study, series=study.series[:1])
    for most_bytes, left in ((sum(sizes), len(sizes)), (0, 1)):
        cache = SeriesCache(folder, most_bytes=most_bytes)
        reduce_study(one, workers=1, tile=TILE, keep=KEPT, cache=cache)
        cache.sweep()
        assert len(list(folder.glob("*.series"))) == left


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.series").write_text("something else")
    with pytest.raises(UsageError, match="--no-cache"):
        SeriesCache(tmp_path)


@pytest.mark.parametrize("step", ["mkdir", "iterdir", "exists", "write_text"])
def test_another_run_may_claim_the_folder_between_any_two_steps(
    folder: Path, step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = getattr(Path, step)

    def late(*args, **options):
        monkeypatch.setattr(Path, step, original)
        SeriesCache(folder)
        (folder / "other.part").write_bytes(b"half")
        return original(*args, **options)

    monkeypatch.setattr(Path, step, late)
    SeriesCache(folder)
    assert (folder / series_cache.TAG).read_text().startswith("Signature: 8a477f597d28d172789f06886806bc55")


def test_cache_options_are_refused_where_they_cannot_hold(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(UsageError, match="contradict"):
        cache_from(tmp_path, no_cache=True, out=out)
    with pytest.raises(UsageError, match="is replaced"):
        opened_cache(Options(cache=CacheChoice(folder=out / "cache")), out=out)
    assert cache_from(None, no_cache=True, out=out) is None
    assert cache_from(None, no_cache=False, out=out) == CacheChoice(folder=tmp_path / "out.cache")
    assert cache_from(out, no_cache=False, out=None) == CacheChoice(folder=out, shared=True)
    assert opened_cache(Options(), out=out) is None
    assert cache_beside(Path("/")) == Path("/.cache")
    assert not out.exists()
