"""The loop of the published article: its cameras simulated as charts come back within the bounds of METHOD 9.

Eight cameras of each here; a hundred were run when this was written (docs/loop.md has their figures).
"""

import json
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from fullwell.workflow.loop.loop import LoopOptions, loop

CAMERAS: Final = 8
STATED: Final = {
    "Sony A6000": "k_dark = 1.672e-4\nk_shot = 5.554e-3\nk_fpn = 5.477e-3\ndigital_maximum = 16383\nblack = 511",
    "Sony, Imatest": "k_dark = 3.207e-4\nk_shot = 0.0100\nk_fpn = 4.99e-3\ndigital_maximum = 4095\nblack = 128",
    "Sony, EMVA": (
        "system_gain = 0.425\nread_noise = 2.36\ndsnu = 0.703\nprnu = 0.687\ndigital_maximum = 4095\nblack = 128"
    ),
}
PLANNED: Final = {
    "Sony A6000": (9.1, 14.5, 78.0),
    "Sony, Imatest": (9.0, 14.0, 227.0),
    "Sony, EMVA": (10.0, 13.5, 135.0),
}
"""METHOD 1.6: expected error of k_dark, k_shot and k_fpn times the square root of the pixels of a patch [%]."""
SYSTEMATIC: Final = (0.02, 0.02, 0.1)
"""What is allowed beside four standard errors of the mean [%]."""
PIXELS: Final = 2500


@pytest.mark.parametrize("camera", list(STATED))
def test_documented_cameras_come_back(camera: str, tmp_path: Path) -> None:
    config = tmp_path / "camera.toml"
    config.write_text(f"seed = 1001\n[figures]\n{STATED[camera]}\n", encoding="utf-8")
    loop(config, tmp_path / "out", options=LoopOptions(repeats=CAMERAS))
    document = json.loads((tmp_path / "out" / "loop.json").read_text(encoding="utf-8"))
    found = {
        one["quantity"]: one
        for one in document["figures"]
        if one["channel"] == "all" and one["method"] == "gamma-likelihood"
    }
    chance = 1.0 + 4.0 / np.sqrt(2.0 * (CAMERAS - 1))  # four standard errors of a standard deviation
    for name, planned, systematic in zip(("k_dark", "k_shot", "k_fpn"), PLANNED[camera], SYSTEMATIC, strict=True):
        one = found[name]
        expected = planned / np.sqrt(PIXELS)
        bias, sd = (100.0 * one[what] / one["truth"] for what in ("bias", "sd"))
        assert one["cameras"] == CAMERAS
        assert abs(bias) <= 4.0 * sd / np.sqrt(CAMERAS) + systematic, (name, bias, sd)
        assert sd <= 1.1 * expected * chance, (name, sd)
        assert 100.0 * one["rms_std_error"] / one["truth"] <= 1.1 * expected
        assert abs(one["pull_mean"]) <= 4.0 / np.sqrt(CAMERAS)
