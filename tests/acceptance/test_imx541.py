"""A real EMVA 1288 campaign through the command line: the folder itself, and the manifest `index` writes."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def results(characterize: Callable, tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> dict:
    study = request.getfixturevalue("shared_data")("imx541")
    _, document = characterize(study, tmp_path_factory.mktemp("imx541") / "out")
    return document


def row(results: dict, quantity: str, method: str, unit: str) -> dict:
    (found,) = (
        one for one in results["results"] if (one["quantity"], one["method"], one["unit"]) == (quantity, method, unit)
    )
    return found


def test_system_gain_is_flagged_for_what_it_is(results: dict) -> None:
    found = row(results, "system_gain", "photon-transfer", "DN/e-")
    assert 0.40 <= found["value"] <= 0.425
    assert "model-misfit" in found["flags"]


def test_read_noise_with_and_without_quantization(results: dict) -> None:
    assert row(results, "read_noise", "temporal-variance", "DN")["value"] == pytest.approx(0.838, rel=0.01)


def test_short_exposures_are_flagged(results: dict) -> None:
    (finding,) = (one for one in results["findings"] if one["code"] == "exposure-deviates")
    for exposure in ("25 µs +4.", "81 µs +2.", "272 µs +1."):
        assert exposure in finding["message"]


def test_manifest_gives_the_same_figures(
    results: dict, characterize: Callable, shared_data: Callable[[str], Path], tmp_path: Path
) -> None:
    manifest = tmp_path / "study.toml"
    command = [sys.executable, "-m", "fullwell", "index", str(shared_data("imx541")), "-o", str(manifest)]
    subprocess.run(command, check=True, capture_output=True)
    _, document = characterize(manifest, tmp_path / "out")
    assert document["results"] == results["results"]
