"""Progress on stderr."""

import io
from itertools import count

import pytest
from rich.console import Console
from rich.progress import Progress

from fullwell.cli import progress as told
from fullwell.cli.bars import BarProgress
from fullwell.cli.progress import LineProgress, shown_progress


def test_quiet_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with shown_progress(quiet=True) as progress:
        assert progress is None
    assert capsys.readouterr() == ("", "")


def test_without_a_terminal_a_line_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ticks = count()
    monkeypatch.setattr(told.time, "monotonic", lambda: float(next(ticks)))
    progress = LineProgress()
    progress.start(10)
    for _ in range(10):
        progress.advance()
    assert (
        capsys.readouterr().err == "5 of 10 frames, 1.0 frames/s, 5 s left\n10 of 10 frames, 1.0 frames/s, 0 s left\n"
    )


def test_short_work_without_a_terminal_is_silent(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    with shown_progress(quiet=False) as progress:
        assert progress is not None
        progress.start(3)
        progress.advance(3)
    assert capsys.readouterr() == ("", "")


def test_bars_count_each_piece_of_work() -> None:
    bars = Progress(console=Console(file=io.StringIO()))
    progress = BarProgress(bars)
    progress.advance()
    for total in (3, 5):
        progress.start(total)
        progress.advance(2)
    assert [(task.total, task.completed) for task in bars.tasks] == [(5, 2)]


def test_a_forced_terminal_gets_bars_with_rate_and_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    with shown_progress(quiet=False) as progress:
        assert progress is not None
        progress.start(4)
        progress.advance(2)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "2/4" in shown.err
    assert "frames" in shown.err
