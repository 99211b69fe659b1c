"""``fullwell model`` as people type it."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fullwell.cli.app import app
from fullwell.raw.write import DngExtras, write_dng

Run = Callable[..., "subprocess.CompletedProcess[str]"]
A6000 = ("--k-dark", "0.0001672", "--k-shot", "0.005554", "--k-fpn", "0.005477", "--digital-maximum", "16383")


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["model", *map(str, arguments)])


def test_the_published_example(run: Run) -> None:
    done = run("model", *A6000, "--saturation-dn", "15021.57")
    assert done.returncode == 0, done.stderr
    for said in ("D = 16383 DN (as given)", "0.505365", "29724.2", "41.9604", "73.9815", "mixed", "DNG NoiseProfile"):
        assert said in done.stdout


def test_json_is_the_document_alone() -> None:
    done = invoke(*A6000, "--white", "16383", "--black", "511", "--json")
    said = json.loads(done.stdout)
    assert done.exit_code == 0
    assert said["schema"] == "fullwell-model/1"
    assert said["given"]["k_dark"] == 0.0001672
    figures = {figure["quantity"]: figure["value"] for figure in said["models"][0]["figures"]}
    assert figures["noise_profile_scale"] == pytest.approx(16383.0 * 0.005554**2 / (16383.0 - 511.0), rel=1e-14)
    assert [finding["code"] for finding in said["findings"]] == [
        "saturation-unknown",
        "dsnu-unknown",
        "fixed-pattern-left-out",
    ]


def test_a_dng_brings_its_noise_profile_and_levels(tmp_path: Path) -> None:
    path = tmp_path / "frame.dng"
    mosaic = np.full((16, 16), 100, np.uint16)
    write_dng(
        path, mosaic, cfa="RGGB", black_level=(64.0,), white_level=1023, extras=DngExtras(noise_profile=((2e-4, 1e-6),))
    )
    said = json.loads(invoke(path, "--json").stdout)
    figures = {figure["quantity"]: figure["value"] for figure in said["models"][0]["figures"]}
    assert figures["system_gain"] == pytest.approx(2e-4 * 959.0, rel=1e-12)
    assert figures["noise_profile_offset"] == pytest.approx(1e-6, rel=1e-12)


def test_an_exposure_has_a_unit() -> None:
    said = json.loads(
        invoke(
            "--system-gain=0.425", "--read-noise=2.36", "--dark-current=2.22", "--exposure=500ms", "--white=4095",
            "--json",
        ).stdout
    )  # fmt: skip
    assert said["models"][0]["conventions"]["exposure_s"] == 0.5


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "no noise model is stated"),
        (("--noise-profile", "1e-4", "--white", "1023"), "give pairs"),
        (("--noise-profile", "1e-4,x", "--white", "1023"), "give S,O as numbers"),
        ((*A6000, "--iso", "100"), "--iso chooses among the models of a file"),
        (("missing.json",), "does not exist"),
        (("missing.json", "--prnu", "1"), "leave --prnu out"),
        ((*A6000, "--exposure", "soon"), "--exposure soon"),
        ((*A6000, "--exposure", "1s,2s"), "give one exposure"),
    ],
)
def test_bad_use_is_a_sentence(arguments: tuple[str, ...], said: str) -> None:
    done = invoke(*arguments)
    assert done.exit_code == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
