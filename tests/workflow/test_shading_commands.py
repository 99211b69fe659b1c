"""Shading maps from a simulated study: fitted, compared, and scenes corrected by them."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from fullwell.errors import UsageError
from fullwell.findings import Severity
from fullwell.fit.shading.surface import ShadingModel
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.raw.opcodes import OpcodeList, mosaic_gain_maps
from fullwell.raw.open import read_raw
from fullwell.raw.rewriting import copy_with_gain_maps, read_opcodes
from fullwell.raw.write import DngExtras, write_dng
from fullwell.testing import simulated_study, simulation
from fullwell.workflow.maps import load_shading_map
from fullwell.workflow.options import Options
from fullwell.workflow.shading.apply import apply_shading
from fullwell.workflow.shading.compare import compare_maps
from fullwell.workflow.shading.fit import fit_maps
from fullwell.workflow.shading.folder import ShadingOutcome
from libraw_oracle import read_with_libraw

FOCAL_LENGTH_MM = 0.25
EXPONENTS = {"R": 1.1, "G1": 1.0, "G2": 1.0, "B": 0.9}
SIZE = (128, 192)
STUDY = {
    "isos": [100, 200],
    "flat": {"exposures_s": [0.002, 0.004], "electrons": [2000.0, 4000.0], "frames": 4},
    "dark": {"exposures_s": [0.01, 0.1], "frames": 3},
    "scene": {"subjects": ["flat", "patches"], "exposure_s": 0.004, "electrons": 4000.0},
    "folders": {"scene": "Interesting"},
}
LENS = {"shading": "cos4", "focal_length_mm": FOCAL_LENGTH_MM, "shading_exponent": EXPONENTS}
PICTURES = [f"{moment}_{style}.png" for moment in ("before", "after") for style in ("linear", "srgb")]


def truth(channel: str, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the simulated lens at mosaic rows and columns (1.4 um pixels)."""
    reach = FOCAL_LENGTH_MM * 1000.0 / 1.4
    y, x = (rows - 63.5) / reach, (columns - 95.5) / reach
    return (1.0 + y[:, None] ** 2 + x[None, :] ** 2) ** (-2.0 * EXPONENTS[channel])


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    config = simulation(study=STUDY, lens=LENS, camera={"dsnu": 0.0, "read_noise_row": 0.0})
    return simulated_study(tmp_path_factory.mktemp("shading") / "study", config).root


@pytest.fixture(scope="module")
def fitted(study: Path) -> ShadingOutcome:
    return fit_maps(study, study.parent / "fit", options=Options(workers=2))


def files(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "shading.json"
    }


def test_fitted_maps_are_the_lens_within_their_errors(fitted: ShadingOutcome) -> None:
    maps = sorted((fitted.out / "maps").glob("shading_*.npz"))
    assert len(maps) == 4
    assert [one["map"] for one in fitted.document["bursts"]] == [f"maps/{path.name}" for path in maps]
    loaded = load_shading_map(maps[1])
    assert (loaded.cfa, loaded.iso, loaded.exposure_s) == ("BGGR", 100.0, 0.004)
    for site, one in enumerate(loaded.channels):
        rows, columns = np.arange(site // 2, SIZE[0], 2), np.arange(site % 2, SIZE[1], 2)
        found = one.at((rows - site // 2) / 2, (columns - site % 2) / 2)
        model = ShadingModel.from_arrays(one.parameters)
        value, covariance = model.surface_and_covariance([0, 0, 63, 63], [0, 95, 0, 95])
        # Known worst in the corners. A plane taken for another would be 7 % off there: 1.41 to the power of 0.2.
        bound = 4.0 * float((np.sqrt(np.diag(covariance)) / value).max())
        assert np.abs(found / truth(one.channel, rows, columns) - 1.0).max() < bound < 0.06


def test_the_axis_of_the_lens_is_found_with_its_error(fitted: ShadingOutcome) -> None:
    """Of the greens, whose fall-off is a cosine-fourth: the middle of the mosaic, and the focal length."""
    axes = {
        (number, channel["channel"]): next(one for one in channel["models"] if one["model"] == "cos4")["optical_axis"]
        for number, burst in enumerate(fitted.document["bursts"])
        for channel in burst["channels"]
        if channel["channel"] in {"G1", "G2"}
    }
    assert len(axes) == 8
    for (_, channel), axis in axes.items():
        top, left = (1, 0) if channel == "G1" else (0, 1)
        expected = {
            "row": (63.5 - top) / 2.0,
            "column": (95.5 - left) / 2.0,
            "focal_length": FOCAL_LENGTH_MM * 1000.0 / 1.4 / 2.0,
        }
        for name, place in expected.items():
            assert axis[name]["unit"] == "pixel"
            assert abs(axis[name]["value"] - place) < 4.5 * axis[name]["std_error"]


def test_corners_are_within_their_errors(fitted: ShadingOutcome) -> None:
    """Of the greens, whose fall-off is a cosine-fourth: what the rule chooses is then free of bias."""
    middle = (np.array([63.5]), np.array([95.5]))
    found = [
        next(one for one in channel["models"] if one["model"] == channel["chosen"])["corner"]
        for burst in fitted.document["bursts"]
        for channel in burst["channels"]
        if channel["channel"] in {"G1", "G2"}
    ]
    expected = truth("G1", np.array([0.0, 127.0]), np.array([0.0, 191.0])).mean() / truth("G1", *middle).item()
    assert len(found) == 8
    for corner in found:
        # The corner pixel of a green plane lies up to a pixel further in: 2 r / (f^2 + r^2) of the light, 1.2 %.
        assert abs(corner["value"] - expected) < 4.0 * corner["std_error"] + 0.012 * expected


def test_coefficients_of_every_model_are_listed(fitted: ShadingOutcome) -> None:
    with (fitted.out / "coefficients.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    published = [row["parameter"] for row in rows if row["model"] == "poly22"]
    assert published[:6] == ["p00", "p10", "p01", "p20", "p11", "p02"]
    assert len(published) == 6 * 16
    assert {row["iso"] for row in rows} == {"100", "200"}
    maps = load_shading_map(fitted.out / "maps" / "shading_iso100_exp000004000us.npz")
    green = next(one for one in maps.channels if one.channel == "G1")
    own = [
        float(row["value"])
        for row in rows
        if (row["model"], row["channel"], row["iso"], row["exposure_s"]) == ("poly22", "G1", "100", "0.004")
    ]
    x, y = green.data.rows[:, None] + 1.0, green.data.columns[None, :] + 1.0
    surface = sum(p * term for p, term in zip(own, (1.0, x, y, x * x, x * y, y * y), strict=True))
    signal = green.data.signal_dn
    # A parabola misses a cosine-fourth by a few percent; any coefficient mistaken for another would miss by more.
    assert np.sqrt(np.nanmean((surface / signal - 1.0) ** 2)) < 0.03
    assert all(float(row["std_error"]) > 0.0 for row in rows if row["model"] == "cos4")
    assert {row["model"] for row in rows if row["chosen"] == "yes"} == {
        channel["chosen"] for burst in fitted.document["bursts"] for channel in burst["channels"]
    }


def test_the_same_maps_for_any_number_of_workers(study: Path, fitted: ShadingOutcome, tmp_path: Path) -> None:
    again = fit_maps(study, tmp_path / "again", options=Options(workers=1))
    assert files(again.out) == files(fitted.out)
    assert {**again.document, "run": None} == {**fitted.document, "run": None}


@pytest.mark.parametrize("source", ["folder", "study", "files"])
def test_bursts_of_one_lens_do_not_differ(study: Path, fitted: ShadingOutcome, tmp_path: Path, source: str) -> None:
    maps = sorted((fitted.out / "maps").glob("shading_*.npz"))
    paths = {"folder": [fitted.out], "study": [study], "files": maps}[source]
    outcome = compare_maps(paths, tmp_path / "out", options=Options(workers=2))
    assert outcome.document["base"]["name"] == "shading_iso100_exp000002000us"
    tests = [channel for one in outcome.document["comparisons"] for channel in one["channels"]]
    assert len(tests) == 12
    assert min(one["p_value"] for one in tests) > 1e-4 / 12  # by chance once in ten thousand runs
    with (tmp_path / "out" / "comparison.csv").open(encoding="utf-8", newline="") as file:
        assert [float(row["p_value"]) for row in csv.DictReader(file)] == pytest.approx(
            [one["p_value"] for one in tests], rel=1e-8
        )
    with np.load(next((tmp_path / "out" / "maps").glob("difference_01_*.npz"))) as opened:
        largest = np.nanmax(np.abs(opened["R.difference"] / opened["R.std_error"]))
        expected = next(one["largest_over_error"] for one in tests if one["channel"] == "R")
        assert largest == pytest.approx(expected, rel=1e-5)
    for name in ("difference.png", "over_error.png"):
        with Image.open(tmp_path / "out" / name) as opened:
            assert (opened.format, opened.width) == ("PNG", 1380)


def test_another_lens_differs(fitted: ShadingOutcome, tmp_path: Path) -> None:
    lens = {**LENS, "focal_length_mm": 0.27}
    one_burst = {**STUDY, "isos": [100], "scene": None}
    config = simulation(seed=2, study={k: v for k, v in one_burst.items() if v}, lens=lens)
    other = simulated_study(tmp_path / "other", config).root
    selection = Selection(exposures_s=(0.002,))
    outcome = compare_maps(
        [fitted.out, other], tmp_path / "out", options=Options(selection=selection, workers=2), same_sensor=False
    )
    assert [one["map"]["exposure_s"] for one in outcome.document["comparisons"]][-1] == 0.002
    assert max(channel["p_value"] for channel in outcome.document["comparisons"][-1]["channels"]) < 1e-6


@pytest.fixture(scope="module")
def applied(study: Path, fitted: ShadingOutcome) -> ShadingOutcome:
    return apply_shading(fitted.out, [study / "Interesting"], study.parent / "applied", options=Options(workers=2))


def test_every_scene_gets_its_files(applied: ShadingOutcome) -> None:
    names = {path.name for path in applied.out.iterdir()}
    endings = ["corrected.dng", "gain_map.dng", *PICTURES]
    assert names == {"shading.json", *(f"{scene}_{end}" for scene in ("flat", "patches") for end in endings)}
    assert applied.findings == ()
    for name in names:
        if name.endswith(".png"):
            with Image.open(applied.out / name) as opened:
                assert (opened.size, opened.mode) == (SIZE[::-1], "RGB")


def test_a_corrected_flat_is_flat(study: Path, applied: ShadingOutcome) -> None:
    before, after = read_raw(study / "Interesting" / "flat.dng"), read_raw(applied.out / "flat_corrected.dng")
    theirs = read_with_libraw(applied.out / "flat_corrected.dng")
    np.testing.assert_array_equal(theirs.mosaic, after.mosaic)
    assert theirs.black_level == after.header.black_level.values
    header = after.header
    assert (header.cfa, header.bit_depth, header.iso, header.exposure_s) == ("BGGR", 16, 100.0, 0.004)
    assert header.black_level.values[0] / 256.0 == applied.document["scenes"][0]["corrected"]["scale"] >= 6.0
    for site in range(4):
        window = (slice(site // 2, None, 2), slice(site % 2, None, 2))
        plane = after.mosaic[window] - header.black_level.values[site]
        corner, centre = plane[:16, :16].mean(), plane[24:40, 40:56].mean()
        raw = before.mosaic[window] - 256.0
        # 256 pixels each; in a corner of red 1000 electrons with 0.6 % PRNU scatter by 3.3 %, in the centre by 2.3 %.
        bound = 4.0 * np.hypot(0.033, 0.023) / 16.0 + 0.004
        assert abs(corner / centre - 1.0) < bound < 0.02
        assert raw[:16, :16].mean() / raw[24:40, 40:56].mean() < 0.75


def test_the_gain_maps_of_the_copy_do_what_the_correction_does(study: Path, applied: ShadingOutcome) -> None:
    source, copy = study / "Interesting" / "patches.dng", applied.out / "patches_gain_map.dng"
    image, corrected = read_raw(copy), read_raw(applied.out / "patches_corrected.dng")
    np.testing.assert_array_equal(image.mosaic, read_raw(source).mosaic)
    np.testing.assert_array_equal(read_with_libraw(copy).mosaic, image.mosaic)
    maps = read_opcodes(copy)[OpcodeList.OPCODE_LIST_2]
    assert len(maps) == 4
    scale = applied.document["scenes"][1]["corrected"]["scale"]
    for site, one in enumerate(maps):
        window = (slice(one.top, one.bottom, 2), slice(one.left, one.right, 2))
        rows, columns = np.arange(SIZE[0])[window[0]], np.arange(SIZE[1])[window[1]]
        raised = (image.mosaic[window] - 256.0) * one.at(rows, columns, size=SIZE)[:, :, 0]
        black = corrected.header.black_level.values[site]
        # The result is rounded to half a code; linear interpolation between 64 x 84 points errs by h^2/8 f'' < 5e-4.
        np.testing.assert_allclose((corrected.mosaic[window] - black) / scale, raised, rtol=5e-4, atol=0.5 / scale)


def test_turned_shifted_and_foreign_scenes(study: Path, fitted: ShadingOutcome, tmp_path: Path) -> None:
    mosaic = read_raw(study / "Interesting" / "flat.dng").mosaic
    options = {"black_level": (256,), "white_level": 4095, "bit_depth": 12}
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    write_dng(scenes / "left.dng", np.ascontiguousarray(np.rot90(mosaic)), cfa="GRBG", **options)
    write_dng(scenes / "shifted.dng", mosaic, cfa="RGGB", **options)
    write_dng(scenes / "small.dng", mosaic[:64], cfa="BGGR", **options)
    copy_with_gain_maps(
        study / "Interesting" / "flat.dng",
        scenes / "own.dng",
        mosaic_gain_maps(np.ones((4, 2, 2)), cfa="BGGR", size=mosaic.shape),
    )
    tifffile.imwrite(scenes / "plain.tiff", mosaic, photometric="minisblack")
    (scenes / "plain.json").write_text(json.dumps({"PixelFormat": "BayerBG12"}), encoding="utf-8")
    (scenes / "broken.dng").write_bytes(b"II*\0")
    outcome = apply_shading(fitted.out, [scenes], tmp_path / "out", options=Options(workers=2))
    said = {Path(one["scene"]).stem: one for one in outcome.document["scenes"]}
    assert set(said) == {"left", "shifted", "own", "plain"}
    assert (said["left"]["turned_right_degrees"], said["left"]["colours_shifted"]) == (270, [0, 0])
    assert (said["shifted"]["turned_right_degrees"], said["shifted"]["colours_shifted"]) == (0, [1, 1])
    assert said["plain"]["black_level"]["source"] == "shading-map"
    assert said["plain"]["white_level"]["values"] == [4095.0] * 4
    codes = {(Path(one.files[0]).stem, one.code, one.severity) for one in outcome.findings}
    assert codes == {
        ("left", "scene-turned", Severity.INFO),
        ("shifted", "scene-cfa-shifted", Severity.INFO),
        ("own", "gain-maps-replaced", Severity.INFO),
        ("plain", "black-level-of-map", Severity.WARNING),
        ("plain", "no-gain-map-copy", Severity.INFO),
        ("small", "scene-not-corrected", Severity.ERROR),
        ("broken", "file-damaged", Severity.ERROR),
    }
    straight = apply_shading(
        fitted.out, [study / "Interesting" / "flat.dng"], tmp_path / "straight", options=Options(workers=1)
    )
    expected = read_raw(straight.out / "flat_corrected.dng").mosaic.astype(int)
    left = read_raw(tmp_path / "out" / "left_corrected.dng").mosaic.astype(int)
    assert np.abs(np.rot90(left, -1) - expected).max() <= 1  # a tie may round either way
    plain = read_raw(tmp_path / "out" / "plain_corrected.dng").mosaic.astype(int)
    assert said["plain"]["corrected"]["scale"] == straight.document["scenes"][0]["corrected"]["scale"]
    # The measured black level is not quite the declared one; both are added again after the division.
    assert np.abs(plain - expected).max() <= 8.0 * 2.2 * abs(said["plain"]["black_level"]["values"][0] - 256.0) + 1


def test_the_camera_s_white_is_used_where_it_is_known(fitted: ShadingOutcome, study: Path, tmp_path: Path) -> None:
    mosaic = read_raw(study / "Interesting" / "flat.dng").mosaic
    options = {"black_level": (256,), "white_level": 4095, "bit_depth": 12, "cfa": "BGGR"}
    extras = DngExtras(as_shot_neutral=(0.5, 1.0, 0.6), orientation=6)
    write_dng(tmp_path / "known.dng", mosaic, extras=extras, **options)
    outcome = apply_shading(fitted.out, [tmp_path / "known.dng"], tmp_path / "out", options=Options(workers=1))
    header = read_raw(outcome.out / "known_corrected.dng").header
    assert header.as_shot_neutral == (0.5, 1.0, 0.6)
    assert header.orientation == 6
    with Image.open(outcome.out / "known_after_srgb.png") as opened:
        assert opened.size == SIZE
        red, green, blue = np.asarray(opened, dtype=float)[32:-32, 32:-32].mean(axis=(0, 1))
    assert max(abs(red - green), abs(blue - green)) < 2.0
    with Image.open(outcome.out / "known_after_linear.png") as opened:
        red, green, _blue = np.asarray(opened, dtype=float)[32:-32, 32:-32].mean(axis=(0, 1))
    assert green - red > 20.0


def test_only_folders_of_ours_are_replaced(fitted: ShadingOutcome, study: Path, tmp_path: Path) -> None:
    scene, out = study / "Interesting" / "flat.dng", tmp_path / "out"
    for _ in range(2):
        apply_shading(fitted.out, [scene], out, options=Options(workers=1))
    before = files(out)
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(UsageError, match=r"notes\.txt"):
        apply_shading(fitted.out, [scene], out, options=Options(workers=1))
    assert files(out) == {**before, "notes.txt": b"mine"}
    other = tmp_path / "other"
    shutil.copytree(study / "Interesting", other)
    with pytest.raises(UsageError, match="left untouched"):
        apply_shading(fitted.out, [scene], other, options=Options(workers=1))
    with pytest.raises(UsageError, match="would replace it"):
        apply_shading(fitted.out, [out], out.parent, options=Options(workers=1))


def test_bad_use_is_said_in_a_sentence(study: Path, fitted: ShadingOutcome, tmp_path: Path) -> None:
    out, options, maps = tmp_path / "out", Options(workers=1), fitted.out / "maps"
    one_map, scenes = next(maps.glob("*.npz")), study / "Interesting"
    darks = Options(selection=Selection(kinds=(Kind.DARK,)))
    for words, command in (
        ("does not exist", lambda: apply_shading(study / "missing.npz", [scenes], out, options=options)),
        ("holds no shading maps", lambda: apply_shading(study, [scenes], out, options=options)),
        ("does not exist", lambda: apply_shading(maps, [study / "nothing.dng"], out, options=options)),
        ("holds no raw files", lambda: apply_shading(maps, [study], out, options=options)),
        ("No scene could be corrected", lambda: apply_shading(maps, [scenes], out, options=options, quarters=1)),
        ("only one shading map", lambda: compare_maps([one_map], out, options=options)),
        ("holds no flat frames", lambda: fit_maps(study, out, options=darks)),
    ):
        with pytest.raises(UsageError, match=words):
            command()
        assert not out.exists()


def test_full_pixels_below_the_rail_are_no_shading(tmp_path: Path) -> None:
    flat = {"exposures_s": [0.002, 0.004, 0.008], "electrons": [2000.0, 4000.0, 9000.0], "frames": 4}
    config = simulation(
        study={"isos": [100], "flat": flat, "dark": {"exposures_s": [0.01], "frames": 3}},
        lens=LENS | {"focal_length_mm": 0.5},
        camera={"full_well": 6000.0, "white_level": 4095},
    )
    study = simulated_study(tmp_path / "study", config).root
    fitted = fit_maps(study, tmp_path / "fit", options=Options(workers=2))
    assert [one["exposure_s"] for one in fitted.document["bursts"]] == [0.002, 0.004]
    said = [one.message for one in fitted.findings if one.code == "shading-not-measured"]
    assert said == [
        "lens shading of G2, G1 at ISO 100, flats of 8 ms, is not measured: it comes too near to saturation"
    ]
