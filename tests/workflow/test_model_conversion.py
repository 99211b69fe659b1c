import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fullwell.errors import UsageError
from fullwell.figures.results import Results, Row
from fullwell.fit.noise_coefficients import k_coefficients
from fullwell.model.noise import noise_coefficients
from fullwell.report.document import results_json
from fullwell.units import DN, DN2, DN_PER_ELECTRON, ONE, Measured, square_root
from fullwell.workflow.model import convert_figures, convert_file, document
from fullwell.workflow.model_figures import StatedFigures

A6000 = StatedFigures(k_dark=0.0001672, k_shot=0.005554, k_fpn=0.005477, digital_maximum=16383.0)
SONY = StatedFigures(
    system_gain=0.425, read_noise=2.36, dsnu=0.703, prnu=0.678, saturation_capacity=9091.0, digital_maximum=4095.0
)

GAINS = st.floats(0.02, 20.0)
NOISES = st.floats(0.5, 50.0)
SPREADS = st.floats(0.0, 5.0)
PERCENTS = st.just(0.0) | st.floats(1e-6, 3.0)
MAXIMA = st.sampled_from([255.0, 1023.0, 4095.0, 16383.0, 65535.0])
SHARES = st.floats(0.0, 0.4)


def value(conversion, dialect, quantity, unit, *, method=None, channel="all"):
    """Return one converted value; ``dialect`` is how its heading starts."""
    return measured(conversion, dialect, quantity, unit, method=method, channel=channel).measured.value


def measured(conversion, dialect, quantity, unit, *, method=None, channel="all"):
    model = next(one for one in conversion.models if one.model.channel == channel)
    return next(
        one.row
        for one in model.figures
        if one.dialect.startswith(dialect)
        and (one.row.quantity, one.row.measured.unit) == (quantity, unit)
        and method in {None, one.row.method}
    )


def compared(conversion):
    """Return what does not depend on D; of noises the variances, whose differences cancel without harm."""
    rows = [one.row for one in conversion.models[0].figures if not one.dialect.startswith("k")]
    roots = {row.quantity.removesuffix("_variance") for row in rows if row.quantity.endswith("_variance")}
    return [row for row in rows if row.quantity not in roots]


def codes(conversion):
    return {finding.code for finding in conversion.findings}


def test_the_published_camera_comes_out_as_method_8_lists_it():
    shown = convert_figures(replace(A6000, saturation_dn=0.9169 * 16383.0))
    assert f"{value(shown, 'DN', 'system_gain', 'DN/e-'):.4f}" == "0.5054"
    assert f"{value(shown, 'electrons', 'saturation_capacity', 'e-'):.0f}" == "29724"
    assert f"{value(shown, 'electrons', 'snr_max', 'dB', method='noise-model'):.2f}" == "41.96"
    assert f"{value(shown, 'electrons', 'dynamic_range', 'dB'):.2f}" == "73.98"
    assert 10.0 ** (value(shown, "electrons", "snr_max", "dB", method="shot-only") / 20.0) == pytest.approx(
        172.407, abs=5e-4
    )


def test_the_published_emva_sensor_comes_out_as_method_8_lists_it():
    shown = convert_figures(SONY)
    assert f"{value(shown, 'k', 'k_dark', '1'):.7f}" == "0.0002651"
    assert f"{value(shown, 'k', 'k_shot', '1'):.6f}" == "0.010187"
    assert f"{value(shown, 'EMVA', 'dynamic_range', 'dB', method='emva1288-py-1.0'):.2f}" == "69.76"
    assert f"{value(shown, 'EMVA', 'dynamic_range', 'dB', method='emva1288-4.0-linear'):.2f}" == "69.61"
    assert f"{value(shown, 'EMVA', 'snr_max', 'dB'):.2f}" == "39.59"


def test_dark_current_adds_its_charge_once():
    """METHOD 4.6: 10 s at 2.22 e-/s make 5.3 e-, not 22.3 e-."""
    shown = convert_figures(replace(SONY, dark_current=2.22, exposure_s=10.0))
    charge = value(shown, "electrons", "total_dark_noise_variance", "e-^2")
    rounding = value(shown, "electrons", "quantization_noise_variance", "e-^2")
    assert f"{math.sqrt(charge - rounding):.1f}" == "5.3"
    assert value(shown, "EMVA", "dark_noise_variance", "e-^2") == pytest.approx(2.36**2 + 22.2, rel=1e-14)


@given(gain=GAINS, noise=NOISES, dsnu=SPREADS, prnu=PERCENTS, charge=SPREADS, maximum=MAXIMA)
def test_electrons_to_k_and_back(gain, noise, dsnu, prnu, charge, maximum):  # noqa: PLR0917 - hypothesis draws them
    """EMVA 1288 figures become k's become the same figures, and the k's are those of the simulator."""
    figures = StatedFigures(
        system_gain=gain,
        read_noise=noise,
        dsnu=dsnu,
        prnu=prnu,
        dark_current=charge,
        exposure_s=1.0,
        digital_maximum=maximum,
    )
    there = convert_figures(figures)
    ks = [value(there, "k", name, "1") for name in ("k_dark", "k_shot", "k_fpn")]
    truth = noise_coefficients(
        system_gain=gain,
        digital_maximum=maximum,
        dark_noise=noise,
        prnu=prnu / 100.0,
        offset_spread=dsnu,
        dark_electrons=charge,
    )
    np.testing.assert_allclose(ks, [truth.k_dark, truth.k_shot, truth.k_fpn], rtol=1e-12)
    k_dark, k_shot, k_fpn = ks
    back = convert_figures(
        StatedFigures(
            k_dark=k_dark,
            k_shot=k_shot,
            k_fpn=k_fpn,
            dsnu=dsnu,
            dark_current=charge,
            exposure_s=1.0,
            digital_maximum=maximum,
        )
    )
    assert value(back, "EMVA", "system_gain", "DN/e-") == pytest.approx(gain, rel=1e-12)
    whole = value(back, "electrons", "total_dark_noise_variance", "e-^2")
    assert value(back, "electrons", "read_noise_variance", "e-^2") == pytest.approx(noise**2, abs=1e-12 * whole)
    assert value(back, "EMVA", "prnu", "%") == pytest.approx(prnu, rel=1e-12)


@given(gain=GAINS, noise=NOISES, maximum=MAXIMA, share=SHARES)
def test_a_noise_profile_and_back(gain, noise, maximum, share):
    levels = {"white": maximum, "black": share * maximum}
    there = convert_figures(StatedFigures(system_gain=gain, read_noise=noise, **levels))
    pair = tuple(value(there, "DNG", name, "1") for name in ("noise_profile_scale", "noise_profile_offset"))
    back = convert_figures(StatedFigures(noise_profile=(pair,), **levels))
    for dialect, quantity, unit in (
        ("DN", "system_gain", "DN/e-"),
        ("DN", "total_dark_noise", "DN"),
        ("k", "k_dark", "1"),
        ("k", "k_shot", "1"),
    ):
        expected = value(there, dialect, quantity, unit)
        assert value(back, dialect, quantity, unit) == pytest.approx(expected, rel=1e-12)


@given(maximum=MAXIMA, share=st.floats(0.01, 0.4), k_dark=st.floats(1e-3, 1e-2), k_shot=st.floats(1e-3, 1e-1))
def test_electrons_do_not_know_the_convention_of_d(maximum, share, k_dark, k_shot):
    """METHOD 0: k_dark goes with 1/D, k_shot with 1/sqrt(D); electrons, decibel, S and O stay."""
    levels = {"white": maximum, "black": share * maximum}
    wide = convert_figures(StatedFigures(k_dark=k_dark, k_shot=k_shot, digital_maximum=maximum, **levels))
    other = [
        one.row.measured.value
        for one in wide.models[0].figures
        if "white level - black level" in one.dialect and one.row.quantity in {"k_dark", "k_shot"}
    ]
    assert other == pytest.approx([k_dark / (1.0 - share), k_shot / math.sqrt(1.0 - share)], rel=1e-12)
    narrow = convert_figures(
        StatedFigures(k_dark=other[0], k_shot=other[1], digital_maximum=maximum - levels["black"], **levels)
    )
    assert narrow.models[0].model.conventions.digital_maximum_is == "white level - black level"
    whole = {
        unit: value(wide, dialect, f"total_dark_noise{power}", unit)
        for dialect, power, unit in (
            ("electrons", "", "e-"),
            ("electrons", "_variance", "e-^2"),
            ("DN", "", "DN"),
            ("DN", "_variance", "DN^2"),
        )
    }
    for one, two in zip(compared(wide), compared(narrow), strict=True):
        expected = one.measured.value
        allowed = 1e-12 * max(abs(expected), whole.get(one.measured.unit, 1.0 if one.measured.unit == "dB" else 0.0))
        assert two.measured.value == pytest.approx(expected, rel=1e-11, abs=allowed)


@given(step=st.sampled_from([2.0, 4.0, 16.0]), gain=GAINS, noise=NOISES)
def test_a_rescaled_file_is_the_same_sensor(step, gain, noise):
    """METHOD 0: with codes q apart, rounding is q^2/12 and native codes have K / q."""
    native = convert_figures(StatedFigures(system_gain=gain, read_noise=noise, digital_maximum=1023.0))
    scaled = convert_figures(
        StatedFigures(system_gain=step * gain, read_noise=noise, digital_maximum=step * 1023.0, step=step)
    )
    for dialect in ("k", "electrons", "EMVA", "DNG"):
        ours = [one.row.measured.value for one in scaled.models[0].figures if one.dialect.startswith(dialect)]
        theirs = [one.row.measured.value for one in native.models[0].figures if one.dialect.startswith(dialect)]
        skip = 1 if dialect == "electrons" else 0  # 1 / K counts the file's DN
        assert ours[skip:] == pytest.approx(theirs[skip:], rel=1e-12)


def test_what_is_unknown_is_said():
    assert codes(convert_figures(A6000)) == {
        "range-unknown",
        "saturation-unknown",
        "dsnu-unknown",
        "fixed-pattern-left-out",
    }
    full = replace(SONY, digital_maximum=None, white=4095.0, black=240.0, prnu=0.0)
    assert codes(convert_figures(full)) == set()
    profile = StatedFigures(noise_profile=((1e-4, 1e-7),), white=4095.0, black=240.0, saturation_dn=3800.0, dsnu=0.1)
    assert codes(convert_figures(profile)) == {"fixed-pattern-unknown"}
    tiny = StatedFigures(k_dark=1e-5, k_shot=0.01, digital_maximum=4095.0)
    assert "parts-exceed-whole" in codes(convert_figures(tiny))
    assert measured(convert_figures(A6000), "electrons", "read_noise", "e-").flags == ("mixed",)
    assert measured(convert_figures(SONY), "electrons", "read_noise", "e-").method == "given"
    assert measured(convert_figures(SONY), "EMVA", "prnu", "%").method == "given"


def test_three_pairs_are_red_green_and_blue():
    pairs = ((1e-4, 1e-7), (2e-4, 2e-7), (3e-4, 3e-7))
    shown = convert_figures(StatedFigures(noise_profile=pairs, white=1023.0, black=64.0))
    assert [one.model.channel for one in shown.models] == ["R", "G", "B"]
    assert value(shown, "DN", "system_gain", "DN/e-", channel="B") == pytest.approx(3e-4 * 959.0, rel=1e-14)


@pytest.mark.parametrize(
    ("figures", "said"),
    [
        (StatedFigures(), "no noise model is stated"),
        (StatedFigures(k_dark=1e-4, digital_maximum=1023.0), "--k-dark and --k-shot"),
        (StatedFigures(k_dark=1e-4, k_shot=0.01), "--digital-maximum is missing"),
        (StatedFigures(noise_profile=((1e-4, 1e-7),)), "needs --white and --black"),
        (replace(A6000, system_gain=0.5), "--k-dark and --system-gain"),
        (replace(A6000, noise_profile=((1e-4, 1e-7),)), "--noise-profile and --k-dark"),
        (StatedFigures(system_gain=0.5, digital_maximum=1023.0), "no noise model is stated"),
        (replace(SONY, read_noise_dn=1.0), "--read-noise and --read-noise-dn"),
        (replace(SONY, dsnu_dn=1.0), "--dsnu and --dsnu-dn"),
        (replace(SONY, system_gain=0.0), "--system-gain 0: give a number above 0"),
        (replace(SONY, read_noise=-1.0), "--read-noise -1: give a number at least 0"),
        (replace(SONY, prnu=math.nan), "--prnu nan"),
        (replace(SONY, exposure_s=-1.0), "--exposure -1"),
        (replace(SONY, black=5000.0), "--black 5000"),
        (replace(SONY, white=4095.0, black=4095.0), "--black 4095"),
        (StatedFigures(noise_profile=((0.0, 1e-7),), white=1023.0), "NoiseProfile 0,1e-07"),
    ],
)
def test_figures_that_make_no_model_are_refused(figures, said):
    with pytest.raises(UsageError, match=said):
        convert_figures(figures)


TRUTH = np.array([4.0**2 * 0.17**2 + 1.0 / 12.0, 0.17, 0.007**2])
SPREAD = np.array([2e-4, 5e-5, 3e-7])
BEST = ("recommended",)


def results(path, *, channels=("R", "all"), extra=()):
    """Write results.json of a camera of 10 bit with the k's of two channels, and more rows."""
    covariance = np.diag(SPREAD**2)
    ks = k_coefficients(TRUTH, covariance, digital_maximum=1023.0)
    rows = []
    for channel in channels:
        place = {"channel": channel, "iso": 55.0}
        rows += [
            Row(quantity=name, method="gamma-likelihood", measured=getattr(ks, name), flags=BEST, **place)
            for name in ("k_dark", "k_shot", "k_fpn", "k_dark_variance", "k_shot_variance", "k_fpn_variance")
        ]
        rows.append(
            Row(quantity="black_level", method="fused", measured=Measured.normal(64.0, 0.01, DN), flags=BEST, **place)
        )
    white = Row(
        quantity="white_level",
        method="metadata",
        channel="R",
        iso=55.0,
        measured=Measured.exact(1023.0, DN),
        flags=BEST,
    )
    text = results_json(Results(study={}, rows=(*rows, white, *extra), findings=(), curves=()))
    path.write_text(text, encoding="utf-8")
    return path


def test_results_become_every_dialect_with_errors(tmp_path):
    shown = convert_file(results(tmp_path / "results.json"))
    assert [one.model.channel for one in shown.models] == ["R", "all"]
    assert shown.models[1].model.conventions.signal_range == 959.0
    gain = measured(shown, "DN", "system_gain", "DN/e-").measured
    assert gain.value == pytest.approx(0.17, rel=1e-12)
    assert gain.std_error == pytest.approx(SPREAD[1], rel=1e-6)
    dark = measured(shown, "electrons", "total_dark_noise", "e-").measured
    electrons = math.sqrt(TRUTH[0]) / 0.17
    assert dark.value == pytest.approx(electrons, rel=1e-12)
    bound = electrons * (0.5 * SPREAD[0] / TRUTH[0] + SPREAD[1] / 0.17)
    assert dark.std_error == pytest.approx(bound, rel=1e-5)
    assert dark.ci95 is not None
    assert dark.ci95[0] < electrons < dark.ci95[1]
    offset = measured(shown, "DNG", "noise_profile_offset", "1").measured
    assert offset.value == pytest.approx(TRUTH[0] / 959.0**2, rel=1e-12)
    assert offset.std_error == pytest.approx(SPREAD[0] / 959.0**2, rel=1e-5)
    assert measured(shown, "k", "k_shot", "1").method == "gamma-likelihood"


def test_what_was_measured_directly_stands_for_itself(tmp_path):
    place = {"channel": "all", "iso": 55.0, "flags": BEST}
    read = Measured.student((4.0 * 0.17) ** 2, 1e-4, 40.0, DN2)
    extra = (
        Row(quantity="read_noise", method="temporal-variance", measured=square_root(read, DN), **place),
        Row(quantity="read_noise_variance", method="temporal-variance", measured=read, **place),
        Row(
            quantity="system_gain",
            method="photon-transfer",
            measured=Measured.normal(0.1701, 2e-5, DN_PER_ELECTRON),
            **place,
        ),
        Row(
            quantity="prnu_variance",
            method="flat-dark-stack",
            measured=Measured.normal(0.49, 0.001, "%^2"),
            **place,
        ),
        Row(
            quantity="saturation_capacity",
            method="temporal-variance-peak",
            measured=Measured.exact(800.0, DN),
            **(place | {"flags": ("lower-bound", "recommended")}),
        ),
    )
    shown = convert_file(results(tmp_path / "results.json", extra=extra))
    row = measured(shown, "DN", "read_noise", "DN")
    assert (row.method, row.measured) == ("temporal-variance", square_root(read, DN))
    assert measured(shown, "DN", "system_gain", "DN/e-").measured.value == 0.1701
    assert value(shown, "electrons", "read_noise", "e-") == pytest.approx(4.0, rel=1e-12)
    assert measured(shown, "electrons", "read_noise", "e-").flags == ()
    bound = measured(shown, "electrons", "snr_max", "dB")
    assert (bound.flags, bound.measured.std_error, bound.measured.ci95) == (("lower-bound",), None, None)
    assert "mixed" not in measured(shown, "EMVA", "prnu", "%").flags
    assert value(shown, "EMVA", "saturation_capacity", "e-") == pytest.approx(800.0 / 0.17, rel=1e-12)


def test_system_gain_and_read_noise_make_a_model_without_k(tmp_path):
    place = {"channel": "mono", "iso": None, "flags": BEST}
    rows = (
        Row(
            quantity="system_gain",
            method="photon-transfer",
            measured=Measured.normal(0.5, 1e-3, DN_PER_ELECTRON),
            **place,
        ),
        Row(
            quantity="read_noise_variance",
            method="temporal-variance",
            measured=Measured.normal(4.0, 1e-2, DN2),
            **place,
        ),
        Row(quantity="white_level", method="metadata", measured=Measured.exact(4095.0, DN), **place),
    )
    shown = convert_file(results(tmp_path / "results.json", channels=(), extra=rows))
    k_dark = measured(shown, "k", "k_dark", ONE, channel="mono").measured
    assert k_dark.value == pytest.approx(math.sqrt(4.0 + 1.0 / 12.0) / 4095.0, rel=1e-12)
    assert k_dark.std_error == pytest.approx(0.5 * 1e-2 / (k_dark.value * 4095.0**2), rel=1e-5)


def test_the_document_can_be_written_and_says_its_conventions(tmp_path):
    said = document(convert_file(results(tmp_path / "results.json")))
    read = json.loads(json.dumps(said, allow_nan=False))
    assert read["schema"] == "fullwell-model/1"
    assert read["models"][0]["conventions"] == {
        "digital_maximum": 1023.0,
        "digital_maximum_is": "white level",
        "white_level": 1023.0,
        "black_level": 64.0,
        "signal_range": 959.0,
        "step": 1.0,
        "exposure_s": 0.0,
    }
    figure = read["models"][0]["figures"][0]
    assert (figure["quantity"], figure["symbol"], figure["unit"]) == ("k_dark", "k_dark", "1")


def test_files_without_a_noise_model_are_refused(tmp_path):
    (tmp_path / "other.json").write_text('{"schema": "other"}', encoding="utf-8")
    (tmp_path / "torn.json").write_text('{"schema": "fullwell-results/1", "results": [{}]}', encoding="utf-8")
    (tmp_path / "note.txt").write_text("not a raw file", encoding="utf-8")
    (tmp_path / "empty").mkdir()
    empty = results(tmp_path / "none.json", channels=())
    for path, said in (
        (tmp_path / "missing", "does not exist"),
        (tmp_path / "empty", "holds no results.json"),
        (tmp_path / "other.json", "no results document"),
        (tmp_path / "torn.json", "no results document"),
        (tmp_path / "note.txt", "Give results.json, or a DNG"),
        (empty, "holds no noise model"),
    ):
        with pytest.raises(UsageError, match=said):
            convert_file(path)
    with pytest.raises(UsageError, match="it has 55"):
        convert_file(results(tmp_path / "results.json"), isos=(100.0,))
