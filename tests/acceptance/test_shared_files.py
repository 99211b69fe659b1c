"""Every file of the shared data, inspected as its README says."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fullwell.raw.headerless_format import parse_format
from fullwell.raw.open import read_raw

Shared = Callable[[str], Path]
SCENE = "width=768,height=512,bits=14,container=16,byte_order=little,cfa="
GEOMETRY = {
    **{f"DSC_1339_768x512_{order.lower()}.raw": SCENE + order for order in ("RGGB", "GRBG", "GBRG", "BGGR")},
    "DSC_1339_768x512_rggb_bpc_test.raw": SCENE + "RGGB",
    "Indoor1_2592x1536_8bit_GRBG.raw": "width=2592,height=1536,bits=8,container=8,cfa=GRBG",
    "BlackImage_1920x1080_12bits_BGGR.raw": "width=1920,height=1080,bits=12,container=16,cfa=BGGR",
    "openisp_1920x1080_10bit.raw": "width=1920,height=1080,bits=10,container=16,cfa=RGGB",
}


def inspected(path: Path, *options: str, status: int = 0) -> dict:
    command = [sys.executable, "-m", "fullwell", "inspect", str(path), "--json", *options]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (status, "")
    (document,) = json.loads(done.stdout)
    return document


def headerless(shared_data: Shared, name: str) -> dict:
    return inspected(shared_data(f"headerless/{name}"), "--headerless", GEOMETRY[name])


def codes(document: dict) -> set[str]:
    return {finding["code"] for finding in document["findings"]}


def message(document: dict, code: str) -> str:
    return next(finding["message"] for finding in document["findings"] if finding["code"] == code)


def test_550d_tag_and_optical_black_disagree(shared_data: Shared) -> None:
    found = inspected(shared_data("colorchecker-550d/colorchart.dng"))
    assert (found["black_level"], found["white_level"], found["cfa"]) == ([2056.0] * 4, 15000.0, "RGGB")
    assert (found["active_area"], found["bit_depth"]) == ([26, 152, 1182, 1886], 14)
    assert (found["width"], found["height"], found["raw_width"], found["raw_height"]) == (1734, 1156, 1888, 1182)
    assert (found["iso"], found["exposure_s"]) == (None, None)
    means = [area["mean_dn"] for area in found["optical_black"]]
    assert np.mean(means) == pytest.approx(2049.0, abs=1.0)
    assert np.mean([area["variance_dn2"] for area in found["optical_black"]]) == pytest.approx(283.0, rel=0.1)
    assert {"black-levels-disagree", "optical-black-noisier"} <= codes(found)
    assert "2056" in message(found, "black-levels-disagree")
    assert "cfa-contradicted" not in codes(found)
    assert found["cfa_content"] == ["RGGB", "BGGR"]


def test_6d_lossy_linear_is_refused(shared_data: Shared) -> None:
    found = inspected(shared_data("lossy-6d/canon_eos_6d.dng"), status=1)
    assert (found["width"], found["height"], found["cfa"]) == (1224, 816, None)
    profile = [[3.31406676e-5, 9.2130e-8], [3.27799e-5, 9.2808e-8], [3.25789e-5, 9.3749e-8]]
    assert found["noise_profile"] == [pytest.approx(plane, rel=1e-4) for plane in profile]
    assert {"lossy-compression", "linear-dng"} <= codes(found)
    assert "black-level-tag-damaged" not in codes(found)


@pytest.mark.parametrize("order", ["RGGB", "GRBG", "GBRG", "BGGR"])
def test_one_scene_in_four_orders_is_the_same_plane_by_plane(order: str, shared_data: Shared) -> None:
    name = f"DSC_1339_768x512_{order.lower()}.raw"
    found = headerless(shared_data, name)
    assert order in found["cfa_content"]
    assert "cfa-contradicted" not in codes(found)
    first = read_raw(
        shared_data("headerless/DSC_1339_768x512_rggb.raw"), headerless=parse_format(SCENE + "RGGB")
    ).mosaic
    mosaic = read_raw(shared_data(f"headerless/{name}"), headerless=parse_format(GEOMETRY[name])).mosaic
    for letter in "RB":
        site, own = "RGGB".find(letter), order.find(letter)
        assert np.array_equal(mosaic[own // 2 :: 2, own % 2 :: 2], first[site // 2 :: 2, site % 2 :: 2])
    greens = [site for site, letter in enumerate(order) if letter == "G"]
    for own, site in zip(greens, (1, 2), strict=True):
        assert np.array_equal(mosaic[own // 2 :: 2, own % 2 :: 2], first[site // 2 :: 2, site % 2 :: 2])


@pytest.mark.parametrize("order", ["RGGB", "GRBG", "GBRG", "BGGR"])
def test_a_wrong_order_is_contradicted(order: str, shared_data: Shared) -> None:
    wrong = {"RGGB": "GRBG", "GRBG": "BGGR", "GBRG": "RGGB", "BGGR": "GBRG"}[order]
    path = shared_data(f"headerless/DSC_1339_768x512_{order.lower()}.raw")
    for declared in (wrong, "mono"):
        assert "cfa-contradicted" in codes(inspected(path, "--headerless", SCENE + declared))


def test_nikon_scales_red_and_blue(shared_data: Shared) -> None:
    found = headerless(shared_data, "DSC_1339_768x512_rggb.raw")
    assert found["code_pattern"] == ["scaled-up", "every", "every", "scaled-up"]
    assert found["code_step"] == [pytest.approx(1.155, abs=0.01), 1.0, 1.0, pytest.approx(1.206, abs=0.01)]
    assert "scaled-codes" in codes(found)


def test_planted_defects_are_told(shared_data: Shared) -> None:
    found = headerless(shared_data, "DSC_1339_768x512_rggb_bpc_test.raw")
    planted = 200  # each at 65535 and at 600, where the darker parts of the scene lie too
    assert planted * 0.95 < found["isolated_pixels"]["above"] <= planted
    assert 50 < found["isolated_pixels"]["below"] <= planted
    assert {"isolated-pixels", "codes-above-bit-depth"} <= codes(found)
    plain = headerless(shared_data, "DSC_1339_768x512_rggb.raw")
    assert "isolated-pixels" not in codes(plain)


def test_eight_bits_clip_at_255(shared_data: Shared) -> None:
    found = headerless(shared_data, "Indoor1_2592x1536_8bit_GRBG.raw")
    assert (found["bit_depth"], found["effective_bits"]) == (8, 8)
    assert found["clips_at"] == [255] * 4
    assert found["cfa_content"] == ["GRBG", "GBRG"]


def test_a_dark_frame_that_is_clipped_at_black(shared_data: Shared) -> None:
    name = "BlackImage_1920x1080_12bits_BGGR.raw"
    found = headerless(shared_data, name)
    assert found["missing_codes"] == [[1, 2, 3, 6, 7]] * 4
    assert {"black-clipped", "missing-codes", "isolated-pixels"} <= codes(found)
    mosaic = read_raw(shared_data(f"headerless/{name}"), headerless=parse_format(GEOMETRY[name])).mosaic
    assert np.mean(mosaic == 0) == pytest.approx(0.3165, abs=5e-5)
    assert np.count_nonzero(mosaic > 50) == 772
    assert found["cfa_content"] == []


def test_every_code_a_multiple_of_four(shared_data: Shared) -> None:
    found = headerless(shared_data, "openisp_1920x1080_10bit.raw")
    assert (found["bit_depth"], found["effective_bits"]) == (10, 8)
    assert found["code_step"] == [4.0] * 4
    assert "multiple of 4" in message(found, "code-step")


@pytest.mark.parametrize("name", ["flat1", "flat2", "bias", "bias1", "bias2", "bias3"])
def test_imx428(name: str, shared_data: Shared) -> None:
    found = inspected(shared_data(f"imx428/{name}.fit"))
    assert (found["width"], found["height"], found["format"]) == (1608, 1104, "fits")
    amplification = 10.8381 if name in {"flat1", "flat2", "bias"} else 2.44663
    assert found["level_tags"]["EGAIN"] == [pytest.approx(amplification, rel=1e-4)]
    assert not codes(found) & {"code-step", "scaled-codes", "missing-codes", "cfa-contradicted", "interleaved-lines"}


@pytest.mark.parametrize("name", ["CRW_0101.CRW", "CRW_0119.CRW"])
def test_powershot_s40(name: str, shared_data: Shared) -> None:
    found = inspected(shared_data(f"makers/{name}"))
    assert (found["bit_depth"], found["cfa"], found["iso"]) == (10, "RGGB", 50)
    assert (found["black_level"], found["white_level"]) == ([32.0] * 4, 1023.0)
    assert len(found["masked_areas"]) == 3
    assert [area["mean_dn"] for area in found["optical_black"]] == [pytest.approx(32.0, abs=0.2)] * 4
    assert found["cfa_content"] == ["RGGB", "BGGR"]
    assert [one["severity"] for one in found["findings"] if one["severity"] != "info"] == []


def test_dc120_is_companded_and_refused(shared_data: Shared) -> None:
    found = inspected(shared_data("makers/P003908.KDC"), status=1)
    assert (found["bit_depth"], found["cfa"]) == (8, "GRBG")
    assert any("tone curve" in one["message"] for one in found["findings"] if one["severity"] == "error")


def test_imx541_frames_raise_no_alarm(shared_data: Shared) -> None:
    for name in ("bright/exp000002867us_n00.tiff", "bright/exp000006443us_n00.tiff", "dark/exp000002867us_n00.tiff"):
        found = inspected(shared_data(f"imx541/{name}"))
        assert [one["code"] for one in found["findings"] if one["severity"] != "info"] == []
        assert (found["width"], found["height"]) == (1128, 1128)


def test_two_components_of_lossless_jpeg(shared_data: Shared) -> None:
    found = inspected(shared_data("synthetic/lj92_2comp_1344x1008.dng"))
    assert (found["cfa"], found["compression"]) == ("BGGR", "lossless-jpeg")
    assert [one["severity"] for one in found["findings"] if one["severity"] != "info"] == []
    mosaic = read_raw(shared_data("synthetic/lj92_2comp_1344x1008.dng")).mosaic
    assert np.array_equal(mosaic, np.load(shared_data("synthetic/lj92_2comp_1344x1008.npy")))
