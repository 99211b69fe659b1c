"""The whole tool through the command line, on frames made and written without any of its code."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from independent_study import Sensor, Truth, write_dng, write_study
from scipy import stats

TRUTH = Truth()


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("independent") / "study"
    write_study(root, TRUTH, seed=20)
    return root


@pytest.fixture(scope="module")
def results(study: Path, characterize: Callable, tmp_path_factory: pytest.TempPathFactory) -> dict:
    status, document = characterize(study, tmp_path_factory.mktemp("out") / "results")
    assert status == 0
    return document


def truth_of(row: dict) -> float | None:
    gain = TRUTH.gain_at(row["iso"]) if row["iso"] else math.nan
    known = {
        ("black_level", "DN"): TRUTH.black,
        ("read_noise", "DN"): TRUTH.read_noise_dn(row["iso"] or 100),
        ("read_noise", "e-"): TRUTH.read_noise_dn(row["iso"] or 100) / gain,
        ("read_noise_row", "DN"): TRUTH.row_noise * gain,
        ("read_noise_row", "e-"): TRUTH.row_noise,
        ("dark_current", "DN/s"): TRUTH.dark_current * gain,
        ("dark_current", "e-/s"): TRUTH.dark_current,
        ("system_gain", "DN/e-"): gain,
        ("prnu", "%"): 100 * TRUTH.prnu,
        ("prnu_variance", "%^2"): (100 * TRUTH.prnu) ** 2,
        ("prnu_pixel_variance", "%^2"): (100 * TRUTH.prnu) ** 2,
        ("prnu_row_variance", "%^2"): 0.0,
        ("prnu_column_variance", "%^2"): 0.0,
        ("dsnu_variance", "e-^2"): TRUTH.dsnu**2,
        ("dsnu_variance", "DN^2"): (TRUTH.dsnu * gain) ** 2,
        ("dsnu_pixel_variance", "DN^2"): (TRUTH.dsnu * gain) ** 2,
        ("dsnu_row_variance", "DN^2"): 0.0,
        ("dsnu_column_variance", "DN^2"): 0.0,
        ("total_dark_noise", "DN"): dark_noise_dn(row) if row["quantity"] == "total_dark_noise" else None,
        ("total_dark_noise", "e-"): dark_noise_dn(row) / gain if row["quantity"] == "total_dark_noise" else None,
    }
    return known.get((row["quantity"], row["unit"]))


def dark_noise_dn(row: dict) -> float:
    """Return read noise, shot noise of the dark current and DSNU of one frame, without quantization."""
    gain = TRUTH.gain_at(row["iso"])
    charge = TRUTH.dark_current * row["exposure_s"]
    return math.sqrt(TRUTH.read_noise_dn(row["iso"]) ** 2 + gain**2 * (charge + TRUTH.dsnu**2))


def judged(results: dict) -> Iterator[tuple[dict, float]]:
    for row in results["results"]:
        truth = truth_of(row)
        if truth is not None and row["std_error"] and not row["method"].startswith("legacy-"):
            yield row, truth


def p_value(row: dict, truth: float) -> float:
    pull = abs(row["value"] - truth) / row["std_error"]
    return float(2 * (stats.norm.sf(pull) if row["dof"] is None else stats.t.sf(pull, row["dof"])))


def test_every_interval_is_honest(results: dict) -> None:
    rows = list(judged(results))
    assert len(rows) > 60
    off = [
        (row["quantity"], row["channel"], row["iso"], row["value"], truth)
        for row, truth in rows
        if p_value(row, truth) < 1e-4
    ]
    assert not off


def test_pulls_together_are_as_scattered_as_they_should_be(results: dict) -> None:
    """Per-channel recommended rows of independent pixels: sum of squared normal pulls within its 1e-4 bounds."""
    scores = [
        stats.norm.isf(p_value(row, truth) / 2) ** 2
        for row, truth in judged(results)
        if row["unit"] in {"DN", "DN/e-"}
        and row["channel"] != "all"
        and row["method"] in {"temporal-variance", "photon-transfer"}
    ]
    assert len(scores) == 16
    low, high = stats.chi2.ppf([1e-4, 1 - 1e-4], len(scores))
    assert low < sum(scores) < high


def test_standard_errors_are_no_wider_than_the_design_allows(results: dict) -> None:
    """Read noise: n (L - 1) degrees of freedom; system gain: Fisher information of five flats and the bias burst.

    Five per cent on top: pixels lose 1/576 of their freedom to the means of 24 x 24 tiles, and the scatter over pixels
    that a read-noise error takes into account is known to 1 % (one standard error), of which it takes the excess.
    """
    n = TRUTH.width * TRUTH.height / 4
    for row, truth in judged(results):
        if row["method"] == "temporal-variance" and row["unit"] == "DN" and row["channel"] != "all":
            total = truth**2 + 1 / 12
            row_share = (TRUTH.row_noise * TRUTH.gain_at(row["iso"])) ** 2 / total
            inflation = 1 + (TRUTH.width / 2 - 1) * row_share**2
            ideal = total * math.sqrt(2 / (n * (TRUTH.biases - 1)) * inflation) / (2 * truth)
            assert row["std_error"] < 1.05 * ideal
        if row["quantity"] == "system_gain" and row["channel"] != "all":
            assert row["std_error"] < 1.05 * ideal_gain_error(row["iso"], row["channel"])


def ideal_gain_error(iso: int, channel: str) -> float:
    """Cramer-Rao bound of the slope from five flat bursts and one bias burst, intercept free."""
    from independent_study import BGGR, FLAT_EXPOSURES_S  # noqa: PLC0415

    gain = TRUTH.gain_at(iso)
    sensor = Sensor(TRUTH, 0)
    (row, column) = next(site for site, name in BGGR.items() if name == channel)
    light = float(sensor.illumination[row::2, column::2].mean())
    electrons = np.array([0.0, *(TRUTH.flux / TRUTH.amplification(iso) * t * light for t in FLAT_EXPOSURES_S)])
    signal = gain * electrons
    variance = TRUTH.read_noise_dn(iso) ** 2 + 1 / 12 + gain * signal
    frames = np.array([TRUTH.biases, *[TRUTH.flats] * len(FLAT_EXPOSURES_S)])
    weight = TRUTH.width * TRUTH.height / 4 * (frames - 1) / (2 * variance**2)
    design = np.stack([np.ones_like(signal), signal])
    return float(np.sqrt(np.linalg.inv(design * weight @ design.T)[1, 1]))


def test_shading_of_the_chosen_model_agrees_with_the_lens(results: dict) -> None:
    models = results["curves"]["shading_models"]
    table = {name: column["values"] for name, column in models.items()}
    chosen = {
        (iso, exposure_s, channel, model)
        for iso, exposure_s, channel, model, said in zip(
            *(table[name] for name in ("iso", "exposure_s", "channel", "model", "chosen")), strict=True
        )
        if said == "yes"
    }
    truths = {quantity: shading_truth(quantity) for quantity in ("shading_corner", "shading_edge_x", "shading_edge_y")}
    rows = [
        row
        for row in results["results"]
        if row["quantity"] in truths and (row["iso"], row["exposure_s"], row["channel"], row["method"]) in chosen
    ]
    assert len(rows) == 3 * 4 * 5 * len(TRUTH.isos)
    off = [
        (row["quantity"], row["channel"], row["method"], row["value"], row["std_error"])
        for row in rows
        if p_value(row, truths[row["quantity"]][row["channel"]]) < 1e-5
    ]
    assert not off


def shading_truth(quantity: str) -> dict[str, float]:
    """Return the relative illumination at the corners or edges of each plane."""
    from independent_study import BGGR  # noqa: PLC0415

    sensor, found = Sensor(TRUTH, 0), {}
    for (row, column), channel in BGGR.items():
        light = sensor.illumination[row::2, column::2]
        middle = light.shape[0] // 2, light.shape[1] // 2
        points = {
            "shading_corner": light[[0, 0, -1, -1], [0, -1, 0, -1]],
            "shading_edge_x": light[middle[0], [0, -1]],
            "shading_edge_y": light[[0, -1], middle[1]],
        }
        found[channel] = float(points[quantity].mean() / light.max())
    return found


def test_published_flows_differ_by_their_factor(results: dict) -> None:
    rows = {
        (row["method"], row["channel"], row["iso"]): row["value"]
        for row in results["results"]
        if row["quantity"] == "read_noise" and row["unit"] == "DN"
    }
    for channel in ("R", "G1", "G2", "B", "all"):
        for iso in TRUTH.isos:
            ratio = rows["legacy-pair-difference", channel, iso] / rows["legacy-burst-mean", channel, iso]
            assert ratio == pytest.approx(math.sqrt(5 / 4), rel=1e-12)


def test_recommended_stands_on_exactly_one_row(results: dict) -> None:
    seen: dict[tuple, int] = {}
    for row in results["results"]:
        key = tuple(row[name] for name in ("quantity", "channel", "unit", "iso", "temperature_c", "snr_threshold"))
        if row["region"] is None and row["exposure_s"] is None and row["channel"] != "G":
            seen[key] = seen.get(key, 0) + ("recommended" in row["flags"])
    assert seen
    assert set(seen.values()) == {1}


def test_same_bytes_for_any_number_of_workers(
    study: Path, results: dict, characterize: Callable, tmp_path: Path
) -> None:
    for workers in ("1", "7"):
        _, other = characterize(study, tmp_path / workers, "--workers", workers)
        assert {**other, "run": None} == {**results, "run": None}


def test_bad_files_are_named_and_change_nothing_else(results: dict, characterize: Callable, tmp_path: Path) -> None:
    root = tmp_path / "study"
    write_study(root, TRUTH, seed=20)
    good = next((root / "flat").rglob("*.dng"))
    (root / "flat" / "ISO_100" / "truncated.dng").write_bytes(good.read_bytes()[:100_000])
    (root / "flat" / "ISO_100" / "text.dng").write_text("not a raw file")
    small = np.full((64, 64), 300, dtype=np.uint16)
    write_dng(root / "flat" / "ISO_100" / "small.dng", small, iso=100, exposure_s=0.002, black=200, white=4095)
    status, document = characterize(root, tmp_path / "out")
    assert status == 1
    errors = {name for finding in document["findings"] if finding["severity"] == "error" for name in finding["files"]}
    assert errors == {f"flat/ISO_100/{name}.dng" for name in ("truncated", "text", "small")}
    assert document["results"] == results["results"]
