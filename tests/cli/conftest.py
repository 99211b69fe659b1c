"""A small study and the program that reads it."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tifffile

Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def program() -> list[str]:
    """Return how the installed console script is started."""
    script = Path(sys.executable).with_name("fullwell.exe" if os.name == "nt" else "fullwell")
    if not script.exists():
        pytest.skip("needs the installed console script `fullwell`")
    return [str(script)]


@pytest.fixture
def run(program: list[str]) -> Run:
    """Return a function that runs the console script."""

    def start(*arguments: str | Path, stdin: str | None = None) -> "subprocess.CompletedProcess[str]":
        command = [*program, *map(str, arguments)]
        environment = {key: value for key, value in os.environ.items() if key not in {"FORCE_COLOR", "COLUMNS"}}
        return subprocess.run(
            command, capture_output=True, text=True, check=False, input=stdin, timeout=120, env=environment
        )

    return start


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """Return a folder with two flat and two dark exposures of two mono frames each, described by sidecars."""
    folder = tmp_path / "study"
    rng = np.random.default_rng(7)
    for kind, level in (("flat", 500.0), ("dark", 12.0)):
        (folder / kind).mkdir(parents=True)
        for exposure_us in (1000, 2000):
            for n in range(2):
                path = folder / kind / f"exp{exposure_us}us_{n}.tiff"
                mosaic = rng.normal(level, 4.0, (32, 48)).round().clip(0, 4095).astype(np.uint16)
                tifffile.imwrite(path, mosaic, photometric="minisblack", metadata=None)
                settings = {"PixelFormat": "Mono12", "BlackLevel": 10.0, "DeviceTemperature": 20.0}
                path.with_suffix(".json").write_text(json.dumps({"selected_settings": settings}), encoding="utf-8")
    return folder
