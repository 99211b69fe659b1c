"""Run the command line as a user does."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def characterize() -> Callable[..., tuple[int, dict]]:
    """Return a function that measures a study and returns the exit status and the document."""

    def run(study: Path, out: Path, *options: str) -> tuple[int, dict]:
        command = [sys.executable, "-m", "fullwell", "characterize", str(study), "-o", str(out), "--quiet", *options]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert done.returncode in {0, 1}, done.stderr
        return done.returncode, json.loads((out / "results.json").read_text())

    return run
