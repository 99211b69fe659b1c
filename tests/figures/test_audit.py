"""T21: the arithmetic of the published noise-model article, recomputed to the digits that METHOD 8 prints.

Each row is what a formula gives, the digits that METHOD 8 prints for it, and what the article prints (None: nothing).
"""

import math

import numpy as np
import pytest

from fullwell.figures.ratios import ratio
from fullwell.model import conversions
from fullwell.model.noise import NoiseCoefficients, noise_coefficients
from fullwell.model.photon_transfer import noise_variance, signal_at_snr, signal_to_noise

A6000 = NoiseCoefficients(k_dark=0.0001672, k_shot=0.005554, k_fpn=0.005477)
D_A6000, V_SAT = 16383.0, 0.9169
IMATEST = NoiseCoefficients(k_dark=0.0003207, k_shot=0.01, k_fpn=0.00499)
EMVA_GAIN, EMVA_DARK, EMVA_DSNU, EMVA_CURRENT, EMVA_PRNU, EMVA_SATURATION = 0.425, 2.36, 0.703, 2.22, 0.00678, 9091.0
IMATEST_GAIN, IMATEST_SATURATION, D_SONY = 0.41, 8334.0, 4095.0


def decibel(value):
    return ratio(value, 0.0, None).decibel.value


def stops(value):
    return ratio(value, 0.0, None).stops.value


def signal_at(ks, snr):
    """V at which the model of normalized signals has a signal-to-noise ratio."""
    return signal_at_snr(snr, dark=ks.k_dark**2, shot=ks.k_shot**2, fixed_pattern=ks.k_fpn**2)


def snr_at(ks, signal):
    return float(signal_to_noise(signal, dark=ks.k_dark**2, shot=ks.k_shot**2, fixed_pattern=ks.k_fpn**2))


def unlit(**parts):
    """Noise of a frame of the EMVA sensor in the dark [e-], rounding only with step=1."""
    given = {"dsnu_electrons2": EMVA_DSNU**2, "step": 0.0, **parts}
    return math.sqrt(conversions.unlit_electrons2(EMVA_DARK**2, system_gain=EMVA_GAIN, **given))


def temporal(**parts):
    return unlit(dsnu_electrons2=0.0, **parts) ** 2


def sony(step):
    return noise_coefficients(
        system_gain=EMVA_GAIN,
        digital_maximum=D_SONY,
        dark_noise=EMVA_DARK,
        prnu=EMVA_PRNU,
        offset_spread=EMVA_DSNU,
        step=step,
    )


def k_shot(system_gain, digital_maximum=D_SONY):
    return math.sqrt(conversions.k_shot_variance(system_gain, digital_maximum=digital_maximum))


def percent(value, reference):
    return 100.0 * (value / reference - 1.0)


V_IMATEST = IMATEST_SATURATION * IMATEST.k_shot**2

AGREEING = {
    "shot SNR at saturation": (math.sqrt(V_SAT) / A6000.k_shot, "172.407", "172.4"),
    "saturation capacity": (V_SAT / A6000.k_shot**2, "29724", "29724"),
    "system gain by k_shot": (
        conversions.system_gain_of_k(A6000.k_shot**2, digital_maximum=D_A6000),
        "0.5054",
        "0.5054",
    ),
    "system gain by capacity": (D_A6000 * V_SAT / 29724.0, "0.5054", "0.5054"),
    "maximum SNR by the coefficients": (decibel(snr_at(A6000, V_SAT)), "41.96", "42.0"),
    "maximum SNR as a ratio": (10.0 ** (42.0 / 20.0), "125.9", "125.9"),
    "dynamic range in stops": (decibel(2.0**12.5), "75.26", "75.2"),
    "k_dark without rounding": (sony(0.0).k_dark, "0.0002556", "0.0002556"),
    "k_shot of the EMVA column": (k_shot(EMVA_GAIN), "0.010187", "0.0102"),
    "k_shot of the Imatest column": (k_shot(IMATEST_GAIN), "0.010006", "0.01"),
    "maximum SNR of the EMVA column": (decibel(math.sqrt(EMVA_SATURATION)), "39.59", "39.6"),
    "maximum SNR of the Imatest column": (decibel(snr_at(IMATEST, V_IMATEST)), "38.39", "38.4"),
    "the same by photon noise alone": (decibel(math.sqrt(IMATEST_SATURATION)), "39.21", "38.4"),
    "ten stops": (decibel(2.0**10), "60.2", "60.2"),
    "dark current in microvolt a second": (1e6 * 0.064 * 0.459 / 1023.0, "28.7", "28.7"),
    "the offset's logarithm": (math.log10(511.0 / D_A6000), "-1.506", "-1.5"),
    "dark noise in electrons": (IMATEST.k_dark / IMATEST.k_shot**2, "3.207", "3.207"),
    "dark noise by the measured gain": (IMATEST.k_dark * D_SONY / IMATEST_GAIN, "3.203", "3.207"),
}

DISAGREEING = {
    "dynamic range by the coefficients": (decibel(V_SAT / signal_at(A6000, 1.0)), "73.98", "75.2"),
    "dynamic range over k_dark": (decibel(V_SAT / A6000.k_dark), "74.78", "75.2"),
    "one patch of the chart": (decibel(10.0**0.2486), "4.97", None),
    "EMVA dynamic range": (
        decibel(EMVA_SATURATION / conversions.reference_sensitivity_threshold(temporal(step=1.0))),
        "69.76",
        "69.7",
    ),
    "the same without rounding": (
        decibel(EMVA_SATURATION / conversions.reference_sensitivity_threshold(temporal())),
        "70.04",
        "69.7",
    ),
    "the same where SNR is 1": (
        decibel(EMVA_SATURATION / conversions.sensitivity_threshold(temporal(step=1.0))),
        "69.61",
        "69.7",
    ),
    "Imatest dynamic range": (decibel(V_IMATEST / signal_at(IMATEST, 1.0)), "66.95", "68.8"),
    "Imatest dynamic range over k_dark": (decibel(V_IMATEST / IMATEST.k_dark), "68.30", "68.8"),
    "Imatest dynamic range of V = 1": (decibel(1.0 / signal_at(IMATEST, 1.0)), "68.53", "68.8"),
    "total dark noise": (unlit(), "2.462", "2.43"),
    "PRNU in the other table": (EMVA_PRNU, "0.00678", "0.00687"),
    "simulated k_shot": (k_shot(0.4307), "0.01026", "0.001026"),
    "total dark noise of 10 s": (unlit(dark_electrons=10.0 * EMVA_CURRENT), "5.3", "22.3"),
    "k_dark with rounding": (sony(1.0).k_dark, "0.0002651", "0.0002556"),
    "what rounding adds to k_dark [%]": (percent(sony(1.0).k_dark, sony(0.0).k_dark), "3.7", None),
    "white level of the offset": (2.0 ** round(math.log2(511.0 * 10.0**1.506)) - 1.0, "16383", "4095"),
    "density ratio of the optimizer": (min(1e5, 10.0**8.7), "100000", "9"),
    "codes of 8 bits": (2.0**8 - 1.0, "255", "256"),
    "simulated system gain, EMVA [%]": (percent(0.4307, 0.425), "1.3", None),
    "simulated system gain, Imatest [%]": (percent(0.4142, 0.41), "1.0", None),
    "simulated k_dark, EMVA [%]": (percent(0.0002772, 0.0002556), "8.5", None),
    "simulated k_dark, Imatest [%]": (percent(0.0003354, 0.0003207), "4.6", None),
    "simulated k_shot, EMVA [%]": (percent(0.01026, 0.0102), "0.6", None),
    "simulated k_shot, Imatest [%]": (percent(0.01006, 0.01), "0.6", None),
    "simulated k_fpn, EMVA [%]": (percent(0.006726, 0.00687), "-2.1", None),
    "simulated k_fpn, Imatest [%]": (percent(0.004636, 0.00499), "-7.1", None),
}


def printed(value, digits):
    """Return a value to as many decimals as some printed digits have."""
    return f"{value:.{len(digits.partition('.')[2])}f}"


@pytest.mark.parametrize("name", AGREEING)
def test_T21_what_agrees(name):  # noqa: N802 - METHOD's name of the test
    value, digits, _article = AGREEING[name]
    assert printed(value, digits) == digits


@pytest.mark.parametrize("name", DISAGREEING)
def test_T21_what_does_not_agree(name):  # noqa: N802 - METHOD's name of the test
    value, digits, article = DISAGREEING[name]
    assert printed(value, digits) == digits
    if article is not None:
        assert printed(value, article) != article


def test_T21_one_number_of_method_is_cut_off():  # noqa: N802 - METHOD's name of the test
    """1 / k_dark is 75.5353 dB: METHOD 8 prints 75.53, which is cut off where 75.54 is the rounded figure."""
    value = decibel(1.0 / A6000.k_dark)
    assert printed(value, "75.5353") == "75.5353"
    assert math.floor(100.0 * value) / 100.0 == 75.53
    assert printed(value, "75.2") != "75.2"


def test_T21_the_article_agrees_with_itself_where_it_should():  # noqa: N802 - METHOD's name of the test
    """The other half of every agreeing row: our digits round to what the article prints."""
    rounded_twice = {"dynamic range in stops", "the same by photon noise alone", "dark noise by the measured gain"}
    for name in AGREEING.keys() - rounded_twice:
        value, _digits, article = AGREEING[name]
        assert printed(value, article) == article, name


def test_T21_dark_charge_squared_is_how_the_article_comes_to_its_total():  # noqa: N802 - METHOD's name of the test
    assert printed(math.hypot(unlit(), 10.0 * EMVA_CURRENT), "22.3") == "22.3"


def test_T21_the_minus_signs_that_initial_values_need():  # noqa: N802 - METHOD's name of the test
    """Without fixed pattern noise, differences of variance over differences of signal give k_shot; sums do not."""
    signal = np.array([1e-4, V_SAT])
    dark, bright = noise_variance(signal, dark=A6000.k_dark**2, shot=A6000.k_shot**2)
    assert math.sqrt((bright - dark) / (signal[1] - signal[0])) == pytest.approx(A6000.k_shot, rel=1e-12)
    assert math.sqrt((bright + dark) / (signal[1] + signal[0])) != pytest.approx(A6000.k_shot, rel=1e-6)


def test_T21_saturation_over_capacity_is_k_shot_squared():  # noqa: N802 - METHOD's name of the test
    """The article calls it k_Nsat once."""
    assert V_SAT / (V_SAT / A6000.k_shot**2) == pytest.approx(A6000.k_shot**2, rel=1e-15)


def test_T21_the_offsets_convention():  # noqa: N802 - METHOD's name of the test
    """METHOD 0: D = white less black raises k_dark by 3.22 % and k_shot by 1.60 %."""
    narrow = D_A6000 - 511.0
    dark_dn2 = conversions.dark_variance(A6000.k_dark**2, digital_maximum=D_A6000)
    system_gain = conversions.system_gain_of_k(A6000.k_shot**2, digital_maximum=D_A6000)
    k_dark = math.sqrt(conversions.k_dark_variance(dark_dn2, digital_maximum=narrow))
    assert printed(percent(k_dark, A6000.k_dark), "3.22") == "3.22"
    assert k_shot(system_gain, narrow) / A6000.k_shot == pytest.approx(1.0160, abs=5e-5)


def test_T21_the_way_back():  # noqa: N802 - METHOD's name of the test
    """METHOD 8: sigma_dark = k_dark / k_shot^2, K = D k_shot^2."""
    ks = sony(1.0)
    assert ks.k_dark / ks.k_shot**2 == pytest.approx(unlit(step=1.0), rel=1e-14)
    assert conversions.system_gain_of_k(ks.k_shot**2, digital_maximum=D_SONY) == pytest.approx(EMVA_GAIN, rel=1e-14)
