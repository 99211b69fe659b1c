"""``fullwell shading`` as people start it."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from fullwell.testing import simulated_study, simulation

Run = Callable[..., "subprocess.CompletedProcess[str]"]
STUDY = {
    "isos": [100],
    "flat": {"exposures_s": [0.002, 0.004], "electrons": [2000.0, 4000.0], "frames": 3},
    "scene": {"subjects": ["patches"], "exposure_s": 0.004, "electrons": 4000.0},
}


def test_from_flats_to_corrected_scenes(run: Run, tmp_path: Path) -> None:
    lens = {"shading": "cos4", "focal_length_mm": 0.25}
    study = simulated_study(tmp_path / "study", simulation(study=STUDY, lens=lens)).root
    fit, compare, apply = (tmp_path / name for name in ("fit", "compare", "apply"))
    done = run("shading", "fit", study, "-o", fit, "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    done = run("shading", "compare", fit, "-o", compare)
    assert done.returncode == 0
    assert "Against shading_iso100_exp000002000us" in done.stdout
    assert "4 ms" in done.stdout
    done = run("shading", "apply", fit, study / "scene", "-o", apply, "--json")
    document = json.loads(done.stdout)
    assert done.returncode == 0
    assert document == json.loads((apply / "shading.json").read_text(encoding="utf-8"))
    assert document["scenes"][0]["turned_right_degrees"] == 0
    done = run("shading", "apply", fit, study / "scene", tmp_path / "study" / "truth.json", "-o", apply)
    assert done.returncode == 1
    assert "not a raw file" in done.stdout
    assert "patches.dng" in done.stdout
    assert f"Results: {apply}" in done.stdout
    done = run("shading", "fit", study, "-o", fit)
    assert done.returncode == 0
    assert "Light that reaches corners" in done.stdout
    assert "G2" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["apply", "map.npz", "scene.dng"], "--out"),
        (["apply", "map.npz", "-o", "out"], "SCENE"),
        (["apply", "map.npz", "scene.dng", "-o", "out"], "map.npz does not exist"),
        (["apply", "map.npz", "scene.dng", "-o", "out", "--turn", "45"], "--turn 45: give 0, 90, 180, 270"),
        (["fit", "nowhere", "-o", "out"], "nowhere does not exist"),
        (["compare", "nowhere", "-o", "out"], "nowhere does not exist"),
        (["nonsense"], "nonsense"),
        ([], "Usage:"),
    ],
)
def test_bad_use_of_shading(run: Run, tmp_path: Path, arguments: list[str], words: str) -> None:
    placed = [str(tmp_path / one) if one in {"out", "map.npz", "scene.dng", "nowhere"} else one for one in arguments]
    done = run("shading", *placed)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["fit", "compare", "apply"])
def test_every_shading_command_has_a_help_page(run: Run, command: str) -> None:
    done = run("shading", command, "-h")
    assert done.returncode == 0
    assert f"shading {command} [OPTIONS]" in done.stdout
