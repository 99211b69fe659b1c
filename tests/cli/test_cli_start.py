"""How the program starts: its overview, its version, what it loads, what it says to bad use."""

import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fullwell import __version__
from fullwell.cli.app import app
from fullwell.cli.options import path_from, source_from
from fullwell.cli.overview import COMMANDS, overview
from fullwell.statistics.moments import LARGEST_TILE

Run = Callable[..., "subprocess.CompletedProcess[str]"]
HEAVY = ("numpy", "scipy", "numba", "PIL", "pyarrow", "tifffile", "pydantic", "rich.console", "rawpy")


@pytest.mark.parametrize("arguments", [["--help"], ["characterize", "--help"]])
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    code = (
        "import sys\n"
        f"sys.argv = ['fullwell', *{arguments!r}]\n"
        "from fullwell.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        f"sys.stderr.write(' '.join(name for name in {HEAVY!r} if name in sys.modules))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "Usage:" in done.stdout
    assert done.stderr == ""


def test_the_overview_takes_at_most_six_times_an_empty_python(program: list[str]) -> None:
    def seconds(command: list[str]) -> float:
        began = time.perf_counter()
        subprocess.run(command, capture_output=True, check=True)
        return time.perf_counter() - began

    pairs = [(seconds([*program, "--help"]), seconds([sys.executable, "-c", "pass"])) for _ in range(7)]
    assert statistics.median(shown / empty for shown, empty in pairs) <= 6.0


def test_the_overview_lists_what_the_program_offers(run: Run) -> None:
    listed = [name for name, _summary in COMMANDS]
    commands = [command.callback.__name__ for command in app.registered_commands if command.callback]
    assert listed == sorted([*commands, *(group.name for group in app.registered_groups)])
    assert run("--help").stdout == overview() == CliRunner().invoke(app, ["--help"]).stdout


@pytest.mark.parametrize("arguments", [[], *([name] for name, _summary in COMMANDS)])
def test_version_everywhere(arguments: list[str]) -> None:
    done = CliRunner().invoke(app, [*arguments, "--version"])
    assert (done.exit_code, done.stdout) == (0, f"fullwell {__version__}\n")


@pytest.mark.parametrize("name", [*(name for name, _summary in COMMANDS), "shading compare", "shading apply"])
def test_every_command_has_a_help_page(name: str) -> None:
    done = CliRunner().invoke(app, [*name.split(), "--help"])
    assert done.exit_code == 0
    assert f"Usage: root {name}" in done.stdout
    assert "...}" not in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "COMMAND --help"),
        (["nonsense"], "nonsense"),
        (["characterize"], "PATH"),
        (["characterize", "x", "--nonsense"], "--nonsense"),
        (["characterize", "x", "--tile", "one"], "--tile"),
        (["characterize", "x", "--tile", "100000"], f"--tile 100000: give 4 to {LARGEST_TILE} pixels"),
        (["characterize", "x", "--tile", "3"], "--tile 3: give 4 to"),
        (["characterize", "x", "--workers", "0"], "--workers"),
        (["characterize", "x", "--workers", "999999999999"], "less than or equal to 1024"),
        (["characterize", "", "--dry-run"], "PATH': the path is empty"),
        (["characterize", "x", "-o", " "], "-o': the path is empty"),
        (["index", ""], "FOLDER': the path is empty"),
        (["demo", "-o", ""], "-o': the path is empty"),
        (["demo", "-o", "~no one/out"], "a folder of that name is ./~no one/out"),
        (["simulate", "x.toml"], "--out"),
    ],
)
def test_bad_use_is_status_2_with_a_sentence(run: Run, arguments: list[str], words: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr


def test_the_home_of_a_path_in_quotes_is_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    assert path_from("~/out") == tmp_path / "out"
    said = CliRunner().invoke(app, ["inspect", "~/one.dng"]).stderr
    assert f"{tmp_path / 'one.dng'} does not exist" in said
    assert source_from("~/study") == tmp_path / "study"
    assert path_from("./~") == Path("~")
