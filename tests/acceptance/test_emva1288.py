"""EMVA 1288 through the command line: the package's figures, an independent campaign, a real camera."""

import json
import math
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from emva_campaign import Truth, take
from scipy.stats import norm

LINEAR, CORRECTED, PACKAGE = "emva1288-4.0-linear", "emva1288-4.0-linear-hp-corrected", "emva1288-py-1.0"
Rows = dict[tuple[str, str], dict]

SCALARS = {
    "K": ("system_gain", "DN/e-"),
    "inverse_K": ("conversion_factor", "e-/DN"),
    "R": ("responsivity", "DN/p"),
    "QE": ("quantum_efficiency", "%"),
    "sigma_y_dark": ("dark_noise", "DN"),
    "sigma_d": ("dark_noise", "e-"),
    "u_e_min": ("sensitivity_threshold", "e-"),
    "u_p_min": ("sensitivity_threshold", "p"),
    "u_e_sat": ("saturation_capacity", "e-"),
    "u_p_sat": ("saturation_capacity", "p"),
    "SNR_max": ("snr_max", "1"),
    "SNR_max_dB": ("snr_max", "dB"),
    "SNR_max_bit": ("snr_max", "bit"),
    "inverse_SNR_max": ("inverse_snr_max", "%"),
    "DR": ("dynamic_range", "1"),
    "DR_dB": ("dynamic_range", "dB"),
    "LE_min": ("linearity_error_min", "%"),
    "LE_max": ("linearity_error_max", "%"),
    "u_I_mean": ("dark_current", "e-/s"),
    "u_I_mean_DN": ("dark_current", "DN/s"),
    "u_I_var": ("dark_current_from_variance", "e-/s"),
    "u_I_var_DN": ("dark_current_from_variance", "DN/s"),
    "DSNU1288": ("dsnu", "e-"),
    "DSNU1288_DN": ("dsnu", "DN"),
    "PRNU1288": ("prnu", "%"),
    **{f"DSNU1288_{theirs}": (f"dsnu_{ours}", "e-") for theirs, ours in (("row", "row"), ("col", "column"))},
    **{f"PRNU1288_{theirs}": (f"prnu_{ours}", "%") for theirs, ours in (("row", "row"), ("col", "column"))},
    "DSNU1288_pixel": ("dsnu_pixel", "e-"),
    "PRNU1288_pixel": ("prnu_pixel", "%"),
    **{
        f"{theirs}{suffix}": (f"stack_{ours}_{light}", "DN^2")
        for suffix, light in (("", "bright"), ("_dark", "dark"))
        for theirs, ours in (
            ("sigma_2_y_stack", "temporal_variance"),
            ("s_2_y_measured", "measured_variance"),
            ("s_2_y", "variance"),
            ("s_2_y_cav", "column_means_variance"),
            ("s_2_y_rav", "row_means_variance"),
            ("s_2_y_col", "column_variance"),
            ("s_2_y_row", "row_variance"),
            ("s_2_y_pixel", "pixel_variance"),
        )
    },
}
"""The package's name of every scalar, and ours with its unit."""


def rows_of(document: dict, method: str) -> Rows:
    return {
        (row["quantity"], row["unit"]): row
        for row in document["results"]
        if row["method"] == method and row["snr_threshold"] in {None, 1.0}
    }


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return take(tmp_path_factory.mktemp("campaign") / "emva", side=200, seed=4)


@pytest.fixture(scope="module")
def measured(campaign: Path, characterize: Callable, tmp_path_factory: pytest.TempPathFactory) -> dict:
    out = tmp_path_factory.mktemp("measured") / "out"
    status, document = characterize(campaign, out, "--profile", LINEAR, "--profile", PACKAGE)
    assert status == 0
    return document


@pytest.fixture(scope="session")
def package() -> Callable[..., str]:
    """Return a function that runs the package in an environment of its own."""
    python = os.environ.get("FULLWELL_EMVA1288")
    if python is None:
        pytest.skip("set FULLWELL_EMVA1288 to a python that has emva1288 1.0.2, numpy < 2 and pillow < 12")

    def run(*arguments: str) -> str:
        script = str(Path(__file__).parent / "emva_peer.py")
        return subprocess.run([python, script, *arguments], check=True, capture_output=True, text=True).stdout

    return run


def assert_equal_to_package(found: Rows, theirs: dict[str, float | None]) -> None:
    for name, key in SCALARS.items():
        value = theirs[name]
        if value is None:
            assert key not in found or found[key]["value"] == 0.0, name
        else:
            assert found[key]["value"] == pytest.approx(value, rel=1e-6), name


@pytest.mark.parametrize(("sweep", "image_format"), [("time", "png"), ("light", "png")])
def test_equal_to_the_package_on_its_own_camera(
    package: Callable[..., str], characterize: Callable, tmp_path: Path, sweep: str, image_format: str
) -> None:
    package("generate", str(tmp_path / "set"), sweep, image_format)
    descriptor = tmp_path / "set" / "EMVA1288descriptor.txt"
    _, document = characterize(descriptor, tmp_path / "out", "--profile", PACKAGE)
    assert_equal_to_package(rows_of(document, PACKAGE), json.loads(package("evaluate", str(descriptor))))


def test_equal_to_the_package_on_an_independent_campaign(
    package: Callable[..., str], measured: dict, campaign: Path
) -> None:
    assert_equal_to_package(rows_of(measured, PACKAGE), json.loads(package("evaluate", str(campaign))))


def true_saturation(truth: Truth) -> float:
    """Return the electrons at which 0.15 % of the pixels lie at the highest code, all spreads taken as normal."""
    z, electrons = float(norm.isf(0.0015)), 1e4
    for _ in range(50):
        shot, pattern = electrons, (truth.prnu_percent / 100.0 * electrons) ** 2
        spread = truth.system_gain * math.sqrt(shot + pattern + truth.dark_noise_e**2 + truth.dsnu_e**2)
        level = truth.top_code - 0.5 - z * spread
        electrons = (level - truth.black_dn) / truth.system_gain - truth.dark_current_e * 0.01
    return electrons


def test_within_its_errors_of_the_truth(measured: dict) -> None:
    truth, found = (
        Truth(),
        rows_of(measured, LINEAR)
        | {key: row for key, row in rows_of(measured, CORRECTED).items() if key[0].startswith(("dsnu", "prnu"))},
    )
    efficiency = truth.quantum_efficiency / 100.0
    variance = truth.dark_noise_e**2 + truth.dark_current_e * 0.0002 + 1 / 12 / truth.system_gain**2
    threshold = math.sqrt(variance + 0.25) + 0.5
    saturation = true_saturation(truth)
    expected = {
        ("system_gain", "DN/e-"): truth.system_gain,
        ("conversion_factor", "e-/DN"): 1.0 / truth.system_gain,
        ("photon_transfer_offset", "DN^2"): 0.0,
        ("responsivity", "DN/p"): truth.system_gain * efficiency,
        ("quantum_efficiency", "%"): truth.quantum_efficiency,
        ("dark_noise", "e-"): math.sqrt(variance - 1 / 12 / truth.system_gain**2),
        ("dark_noise", "DN"): math.sqrt(variance) * truth.system_gain,
        ("sensitivity_threshold", "e-"): threshold,
        ("sensitivity_threshold", "p"): threshold / efficiency,
        ("saturation_capacity", "e-"): saturation,
        ("saturation_capacity", "p"): saturation / efficiency,
        ("snr_max", "1"): math.sqrt(saturation),
        ("dynamic_range", "1"): saturation / threshold,
        ("dark_current", "e-/s"): truth.dark_current_e,
        ("dark_current_from_variance", "e-/s"): truth.dark_current_e,
        ("dsnu_variance", "e-^2"): truth.dsnu_e**2,
        ("prnu_variance", "%^2"): truth.prnu_percent**2,
        ("dsnu_row_variance", "e-^2"): 0.0,
        ("dsnu_column_variance", "e-^2"): 0.0,
        ("prnu_row_variance", "%^2"): 0.0,
        ("prnu_column_variance", "%^2"): 0.0,
    }
    for key, value in expected.items():
        row = found[key]
        assert abs(row["value"] - value) < 4.0 * row["std_error"], (key, row["value"], value, row["std_error"])


def test_an_ideal_camera_passes_the_gate_and_shows_no_linearity_error(measured: dict) -> None:
    found = rows_of(measured, LINEAR)
    assert found["system_gain_deviation", "%"]["value"] < 3.0
    assert "upper-limit" in found["linearity_error", "%"]["flags"]


def test_saturation_between_two_steps_is_interpolated_and_told(measured: dict) -> None:
    found = rows_of(measured, LINEAR)
    assert "interpolated" in found["saturation_capacity", "p"]["flags"]
    (finding,) = (one for one in measured["findings"] if one["code"] == "emva-saturation-interpolated")
    assert "between" in finding["message"]


def test_nothing_is_not_a_number_and_one_row_is_recommended(measured: dict) -> None:
    fields = ("quantity", "channel", "unit", "iso", "temperature_c", "snr_threshold")
    whole = [row for row in measured["results"] if row["region"] is None and row["exposure_s"] is None]
    marked = [tuple(row[name] for name in fields) for row in whole if "recommended" in row["flags"]]
    assert len(marked) == len(set(marked))
    assert {tuple(row[name] for name in fields) for row in whole if row["method"] in {LINEAR, PACKAGE}} <= set(marked)


def test_a_real_camera(shared_data: Callable[[str], Path], characterize: Callable, tmp_path: Path) -> None:
    _, document = characterize(shared_data("imx541"), tmp_path / "out", "--profile", f"{LINEAR},{PACKAGE}")
    found, package = rows_of(document, LINEAR), rows_of(document, PACKAGE)
    gain = found["system_gain", "DN/e-"]
    assert gain["value"] == pytest.approx(0.4226, rel=0.015)
    assert {"dark-line", "model-misfit"} <= set(gain["flags"])
    assert found["dark_noise", "DN"]["value"] == pytest.approx(0.886, abs=0.001)
    assert 0.084 <= round(package["dsnu", "DN"]["value"], 3) <= 0.088
    assert 0.517 <= round(package["prnu", "%"]["value"], 3) <= 0.527  # the data's README, without a high-pass
    (finding,) = (one for one in document["findings"] if one["code"] == "emva-dark-line")
    assert "line through the darks at 3 exposures" in finding["message"]
    assert ("responsivity", "DN/p") not in found
