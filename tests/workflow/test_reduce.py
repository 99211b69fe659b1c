"""A study is reduced to the same bits by any number of threads, whatever is wrong with some of its files."""

import dataclasses
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import xxhash
from mixed_study import HEIGHT, TILE, WIDTH, Mosaics, assert_same, assert_same_reduction, direct, mixed_study

from fullwell.errors import RawFileError, UsageError
from fullwell.findings import Severity
from fullwell.frames.series import Kind, Study
from fullwell.statistics.accumulation import Accumulation
from fullwell.statistics.batch import Batch
from fullwell.statistics.moments import Layout
from fullwell.workflow import plan, scratch, threads
from fullwell.workflow.executor import run_threads
from fullwell.workflow.reduce import reduce_study


@pytest.fixture
def study(tmp_path: Path) -> tuple[Study, Mosaics]:
    return mixed_study(tmp_path)


@pytest.fixture(params=[8, 2], ids=["roomy", "tight"])
def memory(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Leave room for all of a burst, or for less, so that it is added in parts."""
    monkeypatch.setattr(plan, "MOST_SLOTS", request.param)
    return request.param


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.usefixtures("memory")
def test_reduction_equals_statistics_of_the_mosaics(study: tuple[Study, Mosaics], workers: int) -> None:
    found = reduce_study(study[0], workers=workers, tile=TILE)
    assert list(found.statistics) == [series.key for series in study[0].series]
    for series in study[0].series:
        assert_same(found.statistics[series.key], direct(series, study[1]))
    files = {name: xxhash.xxh3_128((study[0].root / name).read_bytes()).hexdigest() for name in sorted(study[1])}
    assert found.hashes == files
    assert found.excluded == found.findings == ()


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.usefixtures("memory")
def test_pairs_depend_on_the_files_alone(
    study: tuple[Study, Mosaics], monkeypatch: pytest.MonkeyPatch, workers: int
) -> None:
    seen: list[tuple[str, str]] = []
    original = Accumulation.add

    def add(self: Accumulation, batch: Batch) -> None:
        seen.extend((batch.names[one], batch.names[other]) for one, other in batch.pairs)
        original(self, batch)

    monkeypatch.setattr(Accumulation, "add", add)
    (study[0].root / "dark-0.02-05.dng").unlink()
    reduce_study(study[0], workers=workers, tile=TILE)
    flat = [(f"flat-0.02-{k:02d}.dng", f"flat-0.02-{k + 1:02d}.dng") for k in (0, 2, 4, 6)]
    short = [(f"flat-0.01-{k:02d}.dng", f"flat-0.01-{k + 1:02d}.dng") for k in (0, 2)]
    dark = [(f"dark-0.02-{k:02d}.dng", f"dark-0.02-{k + 1:02d}.dng") for k in (0, 2)]  # the fifth closes the burst
    assert sorted(seen) == sorted([*flat, *short, *dark])


@pytest.mark.usefixtures("memory")
def test_order_of_files_does_not_matter(study: tuple[Study, Mosaics]) -> None:
    shuffled = dataclasses.replace(
        study[0],
        series=tuple(dataclasses.replace(one, frames=one.frames[::-1]) for one in study[0].series),
    )
    reference = reduce_study(study[0], workers=1, tile=TILE)
    for workers in (1, 3):
        assert_same_reduction(reduce_study(shuffled, workers=workers, tile=TILE), reference)


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.usefixtures("memory")
def test_damaged_frames_are_left_out_and_named(study: tuple[Study, Mosaics], workers: int) -> None:
    root, mosaics = study[0].root, study[1]
    # One of the first five, one of the rest, the only one of its series; cut off, emptied, gone.
    cut, emptied, gone = "flat-0.02-02.dng", "flat-0.02-06.dng", "bias-None-00.dng"
    (root / cut).write_bytes((root / cut).read_bytes()[:-200])
    (root / emptied).write_bytes(b"")
    (root / gone).unlink()
    found = reduce_study(study[0], workers=workers, tile=TILE)
    assert [one.name for one in found.excluded] == sorted([cut, emptied, gone])
    named = {name: finding for finding in found.findings for name in finding.files}
    assert set(named) == {cut, emptied, gone}
    assert named[gone].code == "file-missing"
    assert named[cut].code == "file-truncated"
    assert all(finding.severity is Severity.ERROR for finding in found.findings)
    good = {name: mosaic for name, mosaic in mosaics.items() if name not in named}
    assert ("bias", 100.0, 0.0) not in found.statistics
    for series in study[0].series[:3]:
        assert_same(found.statistics[series.key], direct(series, good))
    flat = found.statistics["flat", 100.0, 0.02]
    assert cut not in flat.frames
    assert len(flat.frames) == 7


def test_a_file_that_grew_is_read_whole(study: tuple[Study, Mosaics]) -> None:
    frames = [dataclasses.replace(frame, size=10) for frame in study[0].series[0].frames]
    for frame in frames:
        path = study[0].root / frame.name
        path.write_bytes(path.read_bytes() + bytes(4 * HEIGHT * WIDTH))
    series = dataclasses.replace(study[0].series[0], frames=tuple(frames))
    found = reduce_study(dataclasses.replace(study[0], series=(series,)), workers=2, tile=TILE)
    assert_same(found.statistics[series.key], direct(series, study[1]))


def test_progress_hears_of_every_frame(study: tuple[Study, Mosaics]) -> None:
    class Listener:
        def __init__(self) -> None:
            self.total, self.done, self.lock = 0, 0, threading.Lock()

        def start(self, total_frames: int) -> None:
            self.total = total_frames

        def advance(self, frames: int = 1) -> None:
            with self.lock:
                self.done += frames

    listener = Listener()
    reduce_study(study[0], workers=3, tile=TILE, progress=listener)
    assert listener.total == listener.done == len(study[1])


def test_an_interrupt_stops_every_thread(study: tuple[Study, Mosaics]) -> None:
    heard = 0
    lock = threading.Lock()

    class Impatient:
        def start(self, total_frames: int) -> None:
            pass

        def advance(self, frames: int = 1) -> None:
            nonlocal heard
            with lock:
                heard += frames
                first = heard == 1
            time.sleep(0.5)  # longer than the main thread sleeps between two looks
            if first:
                signal.raise_signal(signal.SIGINT)

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        reduce_study(study[0], workers=2, tile=TILE, progress=Impatient())
    assert threading.active_count() == before
    assert heard < len(study[1])


@pytest.mark.parametrize("error", [RawFileError("code", "a defect"), KeyboardInterrupt()])
def test_one_failing_thread_stops_the_others(error: BaseException) -> None:
    def work(index: int, stop: Event) -> None:
        if index == 0:
            raise error
        assert stop.wait(60), "the other threads should have been told to stop"

    with pytest.raises(type(error)):
        run_threads(work, workers=3)


@pytest.fixture
def largest_memory(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return a function that tells how much memory for files was asked for."""
    asked: list[int] = []
    original = threads.Slots

    class Counting(original):
        def __init__(self, *, slots: int, slot_bytes: int, layout: Layout, stop: Event | None = None) -> None:
            asked.append(slots * slot_bytes)
            super().__init__(slots=slots, slot_bytes=slot_bytes, layout=layout, stop=stop)

    monkeypatch.setattr(threads, "Slots", Counting)
    return lambda: sum(asked)


def test_memory_for_files_is_bounded(
    study: tuple[Study, Mosaics], largest_memory: Callable[[], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    slot = max(2 * HEIGHT * WIDTH, *(frame.size for series in study[0].series for frame in series.frames))
    monkeypatch.setattr(plan, "MOST_BUFFER_BYTES", 6 * slot)
    found = reduce_study(study[0], workers=3, tile=TILE)
    assert largest_memory() <= 6 * slot
    assert_same(found.statistics[study[0].series[0].key], direct(study[0].series[0], study[1]))


@pytest.mark.parametrize("workers", [1, 2, 7])
@pytest.mark.parametrize("in_files", [False, True])
@pytest.mark.usefixtures("memory")
def test_kept_sums_are_those_of_the_good_frames(
    study: tuple[Study, Mosaics], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, workers: int, in_files: bool
) -> None:
    sizes = 3 * HEIGHT * WIDTH * 2  # two series of flats, one of dark frames
    monkeypatch.setattr(scratch, "MOST_KEPT_BYTES", sizes - in_files)
    folder = tmp_path / "scratch"
    folder.mkdir()
    damaged = "flat-0.02-02.dng"
    (study[0].root / damaged).write_bytes(b"")
    found = reduce_study(study[0], workers=workers, tile=TILE, keep={Kind.FLAT, Kind.DARK}, scratch=folder)
    assert list(found.sums) == [series.key for series in study[0].series if series.kind is not Kind.BIAS]
    for series in study[0].series[:3]:
        frames = [study[1][frame.name] for frame in series.frames if frame.name != damaged]
        sums = found.sums[series.key]
        assert sums.dtype == np.uint16
        assert type(sums) is np.ndarray
        assert not sums.flags.writeable
        np.testing.assert_array_equal(sums, np.sum(frames, axis=0))
    assert len(list(folder.iterdir())) == in_files


def test_nothing_is_kept_unasked(study: tuple[Study, Mosaics]) -> None:
    assert reduce_study(study[0], workers=2, tile=TILE).sums == {}


def test_much_to_keep_needs_a_folder(study: tuple[Study, Mosaics], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scratch, "MOST_KEPT_BYTES", 1)
    with pytest.raises(ValueError, match="name a scratch folder"):
        reduce_study(study[0], workers=1, tile=TILE, keep={Kind.FLAT})


@pytest.mark.parametrize(("height", "width"), [(2, 64), (64, 3)])
def test_planes_of_one_line_are_refused_in_a_sentence(study: tuple[Study, Mosaics], height: int, width: int) -> None:
    with pytest.raises(UsageError, match="one row or column"):
        reduce_study(dataclasses.replace(study[0], height=height, width=width), workers=1)
