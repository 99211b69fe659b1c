"""A file that fails while it is added is left out, named and counted, and leaves nothing behind in the sums."""

import errno
from dataclasses import replace
from pathlib import Path

import pytest
from mixed_study import TILE, Mosaics, assert_same, direct, mixed_study

from fullwell.frames.series import Frame, Kind, Series, Study
from fullwell.kernels.stack import Band
from fullwell.statistics.moments import Layout
from fullwell.workflow.merge_tree import finish, parts_of, sum_part
from fullwell.workflow.reduce import Reduction, reduce_study
from fullwell.workflow.stream import LostFrameError, Stream

LOST = ("flat-0.02-08.dng", "flat-0.01-00.dng", "dark-0.02-02.dng", "bias-None-00.dng")
"""One of the last of its series, the first, one of the first five of a dark series, the only one."""


@pytest.fixture
def study(tmp_path: Path) -> tuple[Study, Mosaics]:
    return mixed_study(tmp_path)


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of files that fail after their first strip; how often they were read is counted."""
    original, heard = Stream.read, []

    def read(self: Stream, strip: Band) -> int:
        top = original(self, strip)
        if strip.top and self.frame.name in LOST:
            heard.append(self.frame.name)
            raise LostFrameError(self.frame, OSError(errno.EIO, "Input/output error"))
        return top

    monkeypatch.setattr(Stream, "read", read)
    return heard


def assert_left_out(found: Reduction, study: Study, mosaics: Mosaics, lost: set[str]) -> None:
    assert {one.name for one in found.excluded} == lost
    good = {name: mosaic for name, mosaic in mosaics.items() if name not in lost}
    for series in study.series:
        if any(frame.name in good for frame in series.frames):
            assert_same(found.statistics[series.key], direct(series, good))
        else:
            assert series.key not in found.statistics


@pytest.mark.parametrize("workers", [1, 2, 7])
def test_a_frame_that_fails_half_way(study: tuple[Study, Mosaics], failing: list[str], workers: int) -> None:
    class Listener:
        total = done = 0

        def start(self, total_frames: int) -> None:
            self.total = total_frames

        def advance(self, frames: int = 1) -> None:
            self.done += frames

    listener = Listener()
    found = reduce_study(study[0], workers=workers, tile=TILE, progress=listener)
    assert sorted(failing) == sorted(LOST)
    assert_left_out(found, *study, set(LOST))
    assert {(one.code, one.reason) for one in found.excluded} == {
        ("file-unreadable", "the file cannot be read (Input/output error)")
    }
    assert sorted(found.hashes) == sorted(set(study[1]) - set(LOST))
    assert listener.done == listener.total == len(study[1])


def test_a_task_of_a_cluster_begins_again(study: tuple[Study, Mosaics], failing: list[str]) -> None:
    layout = Layout(height=study[0].height, width=study[0].width, cfa=study[0].cfa, tile=TILE)

    def outcome(series: Series) -> object:
        (part,) = parts_of(series, layout)
        return finish(series, sum_part(part))

    good = {name: mosaic for name, mosaic in study[1].items() if name not in LOST}
    for series in study[0].series[:3]:
        found = outcome(series)
        assert_same(found.statistics, direct(series, good))
        assert [one.name for one in found.excluded] == [
            name for name in LOST if name in {f.name for f in series.frames}
        ]
    assert len(failing) == 3


def test_a_file_cut_short_while_it_is_read(study: tuple[Study, Mosaics], monkeypatch: pytest.MonkeyPatch) -> None:
    original = Stream.read

    def read(self: Stream, strip: Band) -> int:
        if strip.top and self.frame.name in LOST:
            path = self.frame.header.path
            path.write_bytes(path.read_bytes()[:600])
        return original(self, strip)

    monkeypatch.setattr(Stream, "read", read)
    found = reduce_study(study[0], workers=2, tile=TILE)
    assert_left_out(found, *study, set(LOST))
    assert {one.code for one in found.excluded} == {"file-truncated"}


@pytest.mark.parametrize("engine", ["threads", "cluster"])
@pytest.mark.parametrize("fails", ["when it is opened", "half way"])
def test_a_frame_that_fails_when_it_is_read_once_more(
    study: tuple[Study, Mosaics], monkeypatch: pytest.MonkeyPatch, engine: str, fails: str
) -> None:
    """Of the first five dark frames one is damaged, so that the first five good ones are read again."""
    damaged, lost = "dark-0.02-01.dng", "dark-0.02-02.dng"
    dark = next(one for one in study[0].series if one.kind is Kind.DARK)
    path = next(frame.header.path for frame in dark.frames if frame.name == damaged)
    path.write_bytes(path.read_bytes()[:600])
    begin, go_on, opened = Stream.__init__, Stream.read, []
    error = OSError(errno.EIO, "Input/output error")

    def init(self: Stream, frame: Frame, *rest: object, **options: int) -> None:
        opened.append(frame.name)
        if opened.count(lost) == 2 and frame.name == lost and fails == "when it is opened":
            raise error
        begin(self, frame, *rest, **options)

    def read(self: Stream, strip: Band) -> int:
        if opened.count(lost) == 2 and self.frame.name == lost and strip.top:
            raise LostFrameError(self.frame, error)
        return go_on(self, strip)

    monkeypatch.setattr(Stream, "__init__", init)
    monkeypatch.setattr(Stream, "read", read)
    if engine == "threads":
        found = reduce_study(replace(study[0], series=(dark,)), workers=2, tile=TILE)
        statistics, excluded = found.statistics[dark.key], found.excluded
    else:
        (part,) = parts_of(dark, Layout(height=study[0].height, width=study[0].width, cfa=study[0].cfa, tile=TILE))
        outcome = finish(dark, sum_part(part))
        statistics, excluded = outcome.statistics, outcome.excluded
    assert opened.count(lost) == 2
    assert_same(statistics, direct(dark, {name: one for name, one in study[1].items() if name not in {damaged, lost}}))
    assert [one.name for one in excluded] == [damaged, lost]
