"""A ColorChecker Passport in one frame of a Canon 550D: real noise, a real wrong optical black."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

DENSITIES = (0.05, 0.23, 0.44, 0.70, 1.05, 1.50)
CORNERS = ((716.0, 622.0), (1251.0, 614.0), (1258.0, 922.0), (703.0, 929.0))
"""Centres of the four patches at the corners, clockwise from the brown one [pixel]."""
EDGE = 60


def write_patches(path: Path) -> None:
    lines = ["patch,x,y,width,height,density"]
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = CORNERS
    for row in range(4):
        for column in range(6):
            u, v = column / 5, row / 3
            x = (1 - v) * ((1 - u) * x0 + u * x1) + v * ((1 - u) * x3 + u * x2)
            y = (1 - v) * ((1 - u) * y0 + u * y1) + v * ((1 - u) * y3 + u * y2)
            left, top = (round((centre - EDGE / 2) / 2) * 2 for centre in (x, y))
            density = DENSITIES[column] if row == 3 else ""
            lines.append(f"{'ABCD'[row]}{column + 1},{left},{top},{EDGE},{EDGE},{density}")
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module", params=["patches", "colorchecker-passport", "colorchecker-classic"])
def results(
    request: pytest.FixtureRequest, shared_data: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> dict:
    folder = tmp_path_factory.mktemp("colorchecker")
    write_patches(folder / "patches.csv")
    image = shared_data("colorchecker-550d/colorchart.dng")
    given = request.param == "patches"
    where = ["--patches", str(folder / "patches.csv")] if given else ["--chart", request.param]
    command = [sys.executable, "-m", "fullwell", "chart", str(image), *where]
    done = subprocess.run([*command, "-o", str(folder / "out"), "--quiet"], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "out" / "results.json").read_text())


def row(results: dict, quantity: str, method: str, unit: str) -> dict:
    (found,) = (
        one
        for one in results["results"]
        if (one["quantity"], one["method"], one["unit"], one["channel"]) == (quantity, method, unit, "all")
    )
    return found


def test_system_gain_and_intercept_are_those_of_neighbour_differences(results: dict) -> None:
    assert row(results, "system_gain", "photon-transfer", "DN/e-")["value"] == pytest.approx(2.01, abs=0.09)
    intercept = row(results, "read_noise_variance", "noise-model", "DN^2")["value"] + 1 / 12
    assert intercept == pytest.approx(129.0, abs=15.0)


def test_optical_black_is_not_believed(results: dict) -> None:
    (finding,) = (one for one in results["findings"] if one["code"] == "optical-black-inconsistent")
    assert "7.3 DN below" in finding["message"]
    levels = [one for one in results["results"] if one["quantity"] == "black_level"]
    assert len([one for one in levels if one["method"] == "optical-black"]) == 4
    assert {one["value"] for one in levels if one["method"] == "fused"} == {2056.0}


def test_one_image_is_called_what_it_is(results: dict) -> None:
    assert "offset-not-identified" in row(results, "k_dark", "gamma-likelihood", "1")["flags"]
    assert "mixed" in row(results, "k_fpn", "gamma-likelihood", "1")["flags"]
