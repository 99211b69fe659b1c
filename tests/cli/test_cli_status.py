"""Exit statuses of RESULTS 1, through the commands' own guard."""

import errno
import os
import signal
import subprocess
import time
from collections.abc import Callable, Generator
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from fullwell.cli.app import app
from fullwell.cli.status import guarded, status_of
from fullwell.errors import UsageError
from fullwell.findings import Finding, Severity


def broken(error: BaseException) -> Callable[..., Generator[None, None, None]]:
    def load_study(*_arguments: object) -> Generator[None, None, None]:
        raise error

    return load_study


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (UsageError("Do this instead."), 2, "fullwell: Do this instead."),
        (PermissionError(errno.EACCES, "Permission denied", "there"), 2, "there: Permission denied"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "No space left"),
        (KeyboardInterrupt(), 130, "Interrupted"),
        (ZeroDivisionError("division by zero"), 70, "a bug of ours: ZeroDivisionError: division by zero"),
        (OSError("odd"), 70, "a bug of ours"),
    ],
)
def test_what_goes_wrong_inside_a_command(
    monkeypatch: pytest.MonkeyPatch, error: BaseException, status: int, words: str
) -> None:
    monkeypatch.setattr("fullwell.frames.study.load_study", broken(error))
    done = CliRunner().invoke(app, ["characterize", "anything", "--dry-run"])
    assert done.exit_code == status
    assert words in done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr


def test_a_bug_tells_what_to_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fullwell.frames.study.load_study", broken(KeyError("x")))
    done = CliRunner().invoke(app, ["characterize", "anything", "--dry-run", "--verbose"])
    assert done.exit_code == 70
    for words in ("Traceback", "Python 3", "KeyError", "test_cli_status.py:"):
        assert words in done.stderr


def test_an_error_finding_is_status_1() -> None:
    def finding(severity: Severity) -> Finding:
        return Finding(code="x", severity=severity, message="y")

    assert status_of([finding(Severity.WARNING), finding(Severity.INFO)]) == 0
    assert status_of([finding(Severity.WARNING), finding(Severity.ERROR)]) == 1


def test_an_exit_passes_the_guard_untouched(tmp_path: Path) -> None:
    assert tmp_path.exists()
    with pytest.raises(typer.Exit) as caught, guarded(verbose=False):
        raise typer.Exit(1)
    assert caught.value.exit_code == 1


def interrupt_twice(first: str, second: str, removed: list[str]) -> None:
    with guarded(verbose=False):
        try:
            signal.raise_signal(signal.Signals[first])
        finally:
            signal.raise_signal(signal.Signals[second])
            removed.append("all")


@pytest.mark.parametrize(("first", "second"), [("SIGINT", "SIGINT"), ("SIGTERM", "SIGINT"), ("SIGINT", "SIGTERM")])
@pytest.mark.usefixtures("interruptible")
def test_a_second_interrupt_does_not_stop_the_removal_of_what_is_half_done(first: str, second: str) -> None:
    removed: list[str] = []
    with pytest.raises(typer.Exit) as caught:
        interrupt_twice(first, second, removed)
    assert removed == ["all"]
    assert caught.value.exit_code == 130
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("interruptible")
def test_what_takes_too_long_to_remove_can_be_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fullwell.cli.status._PATIENCE_S", 0.0)
    removed: list[str] = []
    with pytest.raises(typer.Exit) as caught:
        interrupt_twice("SIGINT", "SIGINT", removed)
    assert removed == []
    assert caught.value.exit_code == 130


@pytest.mark.skipif(os.name == "nt", reason="needs a signal that only POSIX can send to one process")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_is_status_130_and_leaves_nothing(program: list[str], tmp_path: Path, name: str) -> None:
    config = tmp_path / "long.toml"
    config.write_text(
        "seed = 1\n[camera]\nwidth = 640\nheight = 480\n"
        "[study]\nisos = [100]\ndark = {exposures_s = [0.5], frames = 20000}\n",
        encoding="utf-8",
    )
    out = tmp_path / "frames"
    command = [*program, "simulate", str(config), "-o", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60.0
        while not list(tmp_path.glob(".frames-*/**/*.dng")):
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.Signals[name])
        _shown, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.endswith("fullwell: Interrupted; nothing was left half-written.\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["long.toml"]
