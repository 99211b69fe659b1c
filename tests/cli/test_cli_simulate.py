"""``fullwell simulate`` as people type it: cameras that ship, sources of others, and configs that cannot be used."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from fullwell.cli.app import app
from fullwell.simulate.config import CAMERAS, parse_config, shipped_config
from fullwell.simulate.config_text import config_text
from fullwell.simulate.plan import plan

SMALL = """
[camera]
width = 64
height = 48
[study]
bias = {exposures_s = [0.001], frames = 2}
"""


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["simulate", *map(str, arguments)])


def test_cameras_that_ship_are_listed_and_printed_for_editing() -> None:
    listed = invoke("--list").stdout
    for name in CAMERAS:
        assert name in listed
        printed = invoke("--camera", name, "--print").stdout
        assert parse_config(printed, name=name, folder=Path()) == shipped_config(name)
        again = parse_config(config_text(shipped_config(name).table), name=name, folder=Path())
        assert again == shipped_config(name)
    assert [len(plan(shipped_config(name))) for name in CAMERAS] == [342, 2, 146, 34]


def test_the_folder_holds_the_config_that_was_used_and_the_truth(tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SMALL, encoding="utf-8")
    done = invoke(tmp_path / "small.toml", "-o", tmp_path / "out", "--seed", "5", "--workers", "2")
    assert done.exit_code == 0, done.stderr
    assert "fullwell characterize" in done.stdout
    used = (tmp_path / "out" / "config.toml").read_text(encoding="utf-8")
    assert used.startswith("seed = 5\n")
    again = invoke(tmp_path / "out" / "config.toml", "-o", tmp_path / "again", "--quiet")
    assert (again.exit_code, again.stdout) == (0, "")
    truth = [(tmp_path / name / "truth.json").read_bytes() for name in ("out", "again")]
    assert truth[0] == truth[1]
    frame = "bias/ISO_100/exp000001000us_n01.dng"
    assert (tmp_path / "out" / frame).read_bytes() == (tmp_path / "again" / frame).read_bytes()


def test_published_figures_become_a_chart_or_a_study() -> None:
    ks = "k_dark=1.672e-4,k_shot=5.554e-3,k_fpn=5.477e-3,digital_maximum=16383,black=511"
    done = invoke("--from", ks, "--print")
    assert done.exit_code == 0
    assert "DSNU is not known" in done.stderr
    config = parse_config(done.stdout, name="printed", folder=Path())
    assert config.sensor.prnu == pytest.approx(5.477e-3)
    emva = "system_gain=0.425,read_noise=2.36,dsnu=0.703,prnu=0.687,digital_maximum=4095,saturation_capacity=9091"
    study = parse_config(invoke("--from", emva, "--design", "study", "--print").stdout, name="printed", folder=Path())
    assert study.sensor.full_well == pytest.approx(9091.0)
    assert {frame.kind.value for frame in plan(study)} == {"flat", "dark", "bias"}
    phone = invoke("--from", "noise_profile=3.3e-5:9.2e-8,white=15000,black=2048", "--print")
    assert phone.exit_code == 0, phone.stderr


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ((), ["CONFIG.toml", "--camera", "--from"]),
        (("--camera", "pixel"), ["pixel", "pixel-4a", "imx541"]),
        (("--camera", "imx541", "--from", "k_dark=1"), ["Give one of"]),
        (("--camera", "imx541", "--design", "chart"), ["--design chart"]),
        (("--camera", "imx541", "--seed", "-1"), ["--seed -1", "0 to 2^63"]),
        (("--from", "k_drak=1"), ["k_drak", "k_dark"]),
        (("--from", "k_dark=much"), ["k_dark=much", "number"]),
        (("--from", "noise_profile=1e-4:1e-6:1e-4,white=1000"), ["pairs"]),
        (("--from", "k_dark=1e-4,k_shot=1e-2,digital_maximum=4095", "--design", "film"), ["film", "chart and study"]),
        (("--from", "missing.dng"), ["missing.dng", "does not exist"]),
        (("--from", "missing.json"), ["missing.json", "does not exist"]),
        (("missing.toml",), ["missing.toml cannot be read: No such file or directory."]),
    ],
)
def test_bad_use_is_one_sentence(tmp_path: Path, arguments: tuple[str, ...], parts: list[str]) -> None:
    done = invoke(*arguments, "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert "Traceback" not in done.stderr
    assert [part for part in parts if part not in done.stderr] == []


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[camera]\nread_nois = 3\n", ["camera.read_nois = 3", "Did you mean read_noise?"]),
        ("[study.flat]\nexposure_s = [1]\nelectrons = [1]\n", ["study.flat.exposure_s", "Did you mean exposures_s?"]),
        ("[[camera.at_iso]]\niso = 200\nsystem_gian = 1\n", ["camera.at_iso.0.system_gian", "system_gain"]),
        ("[camera]\nread_noise = -0.1\n", ["camera.read_noise = -0.1", "0 to 1e7", "electrons"]),
        ("[camera]\ndsnu_row = -1\n", ["camera.dsnu_row = -1", "0 to 1e7"]),
        ('[camera]\nread_noise = "2.5 e-"\n', ['camera.read_noise = "2.5 e-"', "a number", "electrons"]),
        ("[camera]\nprnu_column = 30\n", ["camera.prnu_column = 30", "0 to 20", "percent"]),
        ("[camera]\nbit_depth = 12.5\n", ["camera.bit_depth = 12.5", "whole number from 8 to 16"]),
        ("[camera]\nwidth = true\n", ["camera.width = true", "whole number"]),
        ("[camera]\nblack_level = 4095\n", ["camera.black_level = 4095", "white_level = 4095", "below 4095"]),
        ("[[camera.at_iso]]\niso = 200\nblack_level = 5000\n", ["black_level = 5000", "white_level"]),
        ("[[camera.at_iso]]\niso = 200\nread_noise = -1\n", ["camera.at_iso.0.read_noise = -1", "0 to 1e7, in el"]),
        ("[study]\nisos = [1]\ntemperature_c = -300\n", ["study.temperature_c = -300", "-273 to 200"]),
        ("[study]\nflat = {exposures_s = [1], electrons = [1e30]}\n", ["study.flat.electrons.0 = 1e+30", "0 to 1e7"]),
        ("[output]\npreview = 1\n", ["output.preview = 1", "true or false"]),
        ("[camera]\nhot_pixels = 0.9\n", ["camera.hot_pixels = 0.9", "0 to 0.5"]),
        ("[camera]\nbrighter_fatter = -1e-6\n", ["camera.brighter_fatter = -1e-06", "0 to 1e-4"]),
        ("[camera]\nblooming = 2\n", ["camera.blooming = 2", "fraction from 0 to 1"]),
        ("[camera]\ndual_conversion_ratio = 1\n", ["camera.dual_conversion_ratio = 1", "above 1"]),
        ("[camera]\ndark_current_spread = 1\n", ["camera.dark_current_spread = 1", "dark_current above 0"]),
        ("[camera]\ncolour_matrix = [[1, 0], [0, 1]]\n", ["camera.colour_matrix", "three rows of three"]),
        ("[lens]\ndefocus = -1\n", ["lens.defocus = -1", "0 to 50", "pixels"]),
        ('[lens]\nfocal_length_mm = "4 mm"\n', ['lens.focal_length_mm = "4 mm"', "in mm"]),
        ("[output]\noptical_black = {left = 3}\n", ["output.optical_black.left = 3", "even"]),
        ("[output]\ncompanding_bits = 12\n", ["output.companding_bits = 12", "from 4 to 11"]),
        ('[output]\nformat = "tiff"\ncompanding_bits = 8\n', ["output.companding_bits", '"dng"']),
        ('[output]\nformat = "png"\n', ['output.format = "png"', "dng, tiff or headerless"]),
        ("[study]\nisos = [0]\n", ["study.isos.0 = 0", "1 to 65534"]),
        ('[[study.series]]\nkind = "flt"\niso = 1\nexposure_s = 1\n', ['study.series.0.kind = "flt"', "flat, dark"]),
        ("[[study.series]]\niso = 100\nexposure_s = 1\n", ["study.series.0.kind is missing"]),
        ("[chart]\npatches = [{name = 'a', x = 1, y = 0, width = 8, height = 8}]\n", ["patches.0.x = 1", "even"]),
        ("[chart]\ndensities = [-1]\n", ["chart.densities", "densities from 0 to 10"]),
        ("seed = -1\n", ["seed = -1", "0 to 2^63 - 1"]),
    ],
)
def test_a_bad_config_names_key_value_and_range(tmp_path: Path, text: str, parts: list[str]) -> None:
    study = "" if "[study" in text else "\n[study]\nbias = {exposures_s = [0.1]}\n"
    (tmp_path / "bad.toml").write_text(text + study, encoding="utf-8")
    done = invoke(tmp_path / "bad.toml", "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert [part for part in parts if part not in done.stderr] == []
    assert not (tmp_path / "out").exists()


def test_a_config_may_begin_with_a_byte_order_mark(tmp_path: Path) -> None:
    (tmp_path / "marked.toml").write_text("[study]\nbias = {exposures_s = [0.1]}\n", encoding="utf-8-sig")
    assert invoke(tmp_path / "marked.toml", "--print").exit_code == 0


def test_charts_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    chart = "[study]\nchart = {exposures_s = [1], electrons = [100]}\n"
    for text, parts in (
        (chart, ["chart.densities is missing"]),
        (f"[chart]\ndensities = [0, 1, 2]\ncolumns = 100\n{chart}", ["too small", "8 or more"]),
        (f'[chart]\nname = "colourchecker"\n{chart}', ["colourchecker", "colorchecker-classic"]),
        (f'[chart]\ndensities = "none.csv"\n{chart}', ["none.csv", "cannot be read"]),
    ):
        (tmp_path / "bad.toml").write_text(text, encoding="utf-8")
        done = invoke(tmp_path / "bad.toml", "-o", tmp_path / "out")
        assert done.exit_code == 2
        assert [part for part in parts if part not in done.stderr] == []


def test_results_bring_their_camera(tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text(json.dumps({"schema": "something"}), encoding="utf-8")
    done = invoke("--from", tmp_path / "other.json", "--print")
    assert done.exit_code == 2
    assert "no results document" in done.stderr
