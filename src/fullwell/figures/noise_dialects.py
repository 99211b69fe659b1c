"""The figures of a noise model as k's, in DN, in electrons and as the tag NoiseProfile; `noise_emva` has EMVA 1288's.

Noises are computed as signed variances and their intervals mapped by the square root (METHOD 0), so that a read noise
of which rounding leaves nothing comes out as 0 with its variance beside it.
"""

import math
from typing import Final

from fullwell.figures.noise_definition import Definition, decibel, saturation, saturation_e, times
from fullwell.figures.noise_model import Conventions, NativeModel
from fullwell.model import conversions
from fullwell.model.photon_transfer import noise_variance, signal_at_snr
from fullwell.model.quantization import quantization_variance
from fullwell.units import DECIBEL, DN, DN_PER_ELECTRON, DN_PER_SECOND, ELECTRON, ONE, STOP

ELECTRON_PER_DN: Final = "e-/DN"


def _snr_at_saturation(model: NativeModel, to: Conventions) -> float | None:
    if model.fixed is None:
        return None
    level = saturation(model, to)
    variance = noise_variance(level, dark=model.dark_dn2, shot=model.system_gain, fixed_pattern=model.fixed)
    return level / math.sqrt(float(variance)) if variance > 0.0 else None


def _range(model: NativeModel, to: Conventions) -> float | None:
    """Return saturation over the signal at which one frame has SNR 1; None where it never has."""
    dark, shot, fixed = max(model.dark_dn2, 0.0), model.system_gain, model.fixed or 0.0
    threshold = signal_at_snr(1.0, dark=dark, shot=shot, fixed_pattern=fixed)
    return saturation(model, to) / threshold if math.isfinite(threshold) else None


def _range_in_decibel(model: NativeModel, to: Conventions) -> float | None:
    return decibel(_range(model, to))


def _range_in_stops(model: NativeModel, to: Conventions) -> float | None:
    ratio = _range(model, to)
    return None if ratio is None else math.log2(ratio)


def k_definitions(digital_maximum: float, *, direct: bool) -> tuple[Definition, ...]:
    """Return the three k's relative to a digital maximum D [DN]; ``direct`` where measured k's are relative to it."""
    return (
        Definition(
            quantity="k_dark",
            unit=ONE,
            symbol="k_dark",
            equation="sqrt(A) / D",
            formula=lambda model, _: conversions.k_dark_variance(model.dark_dn2, digital_maximum=digital_maximum),
            root=True,
            direct=direct,
        ),
        Definition(
            quantity="k_shot",
            unit=ONE,
            symbol="k_shot",
            equation="sqrt(K / D)",
            formula=lambda model, _: conversions.k_shot_variance(model.system_gain, digital_maximum=digital_maximum),
            root=True,
            direct=direct,
        ),
        Definition(
            quantity="k_fpn",
            unit=ONE,
            symbol="k_fpn",
            equation="sqrt(C)",
            formula=lambda model, _: model.fixed,
            root=True,
            direct=direct,
        ),
    )


IN_DN: Final = (
    Definition(
        quantity="system_gain",
        unit=DN_PER_ELECTRON,
        symbol="K",
        equation="D k_shot^2",
        formula=lambda model, _: model.system_gain,
    ),
    Definition(
        quantity="total_dark_noise",
        unit=DN,
        symbol="sqrt(A)",
        equation="D k_dark",
        formula=lambda model, _: model.dark_dn2,
        root=True,
    ),
    Definition(
        quantity="quantization_noise",
        unit=DN,
        symbol="q / sqrt(12)",
        equation="q / sqrt(12)",
        formula=lambda _, to: quantization_variance(to.step),
        root=True,
        source="METHOD 3.3",
    ),
    Definition(
        quantity="read_noise",
        unit=DN,
        symbol="K sigma_read",
        equation="K sqrt(A/K^2 - DSNU^2 - i t - q^2/12K^2)",
        formula=lambda model, _: model.read_e2 * model.system_gain**2,
        root=True,
        rests_on=frozenset({"split", "rounding"}),
    ),
    Definition(
        quantity="dsnu",
        unit=DN,
        symbol="K DSNU",
        equation="K DSNU",
        formula=lambda model, _: times(model.dsnu_e2, model.system_gain**2),
        root=True,
    ),
    Definition(
        quantity="dark_current",
        unit=DN_PER_SECOND,
        symbol="K i",
        equation="K i",
        formula=lambda model, _: times(model.dark_current, model.system_gain),
    ),
    Definition(
        quantity="saturation_capacity",
        unit=DN,
        symbol="D V_sat",
        equation="D V_sat",
        formula=saturation,
        rests_on=frozenset({"saturation"}),
    ),
)

IN_ELECTRONS: Final = (
    Definition(
        quantity="conversion_factor",
        unit=ELECTRON_PER_DN,
        symbol="1 / K",
        equation="1 / (D k_shot^2)",
        formula=lambda model, _: 1.0 / model.system_gain,
    ),
    Definition(
        quantity="total_dark_noise",
        unit=ELECTRON,
        symbol="sigma_dark",
        equation="k_dark / k_shot^2",
        formula=lambda model, _: model.dark_dn2 / model.system_gain**2,
        root=True,
    ),
    Definition(
        quantity="quantization_noise",
        unit=ELECTRON,
        symbol="q / (K sqrt(12))",
        equation="q / (K sqrt(12))",
        formula=lambda model, to: conversions.rounding_electrons2(system_gain=model.system_gain, step=to.step),
        root=True,
        source="METHOD 3.3",
    ),
    Definition(
        quantity="read_noise",
        unit=ELECTRON,
        symbol="sigma_read",
        equation="sqrt(A/K^2 - DSNU^2 - i t - q^2/12K^2)",
        formula=lambda model, _: model.read_e2,
        root=True,
        rests_on=frozenset({"split", "rounding"}),
    ),
    Definition(
        quantity="saturation_capacity",
        unit=ELECTRON,
        symbol="C_sat",
        equation="V_sat / k_shot^2",
        formula=saturation_e,
        source="METHOD 7",
        rests_on=frozenset({"saturation"}),
    ),
    Definition(
        quantity="snr_max",
        unit=DECIBEL,
        symbol="SNR_max",
        equation="V_sat / sqrt(k_dark^2 + k_shot^2 V_sat + k_fpn^2 V_sat^2)",
        formula=lambda model, to: decibel(_snr_at_saturation(model, to)),
        method="noise-model",
        source="METHOD 7",
        rests_on=frozenset({"saturation"}),
    ),
    Definition(
        quantity="snr_max",
        unit=DECIBEL,
        symbol="SNR_shot",
        equation="sqrt(V_sat) / k_shot",
        formula=lambda model, to: decibel(math.sqrt(saturation_e(model, to))),
        method="shot-only",
        source="METHOD 7",
        rests_on=frozenset({"saturation"}),
    ),
    *(
        Definition(
            quantity="dynamic_range",
            unit=unit,
            symbol="DR",
            equation="V_sat / V_1, V_1 where one frame has SNR 1",
            formula=formula,
            method="noise-model",
            source="METHOD 7",
            snr_threshold=1.0,
            rests_on=frozenset({"saturation"}),
        )
        for unit, formula in (
            (DECIBEL, _range_in_decibel),
            (STOP, _range_in_stops),
        )
    ),
)

NOISE_PROFILE: Final = (
    Definition(
        quantity="noise_profile_scale",
        unit=ONE,
        symbol="S",
        equation="K / (white - black)",
        formula=lambda model, to: conversions.noise_profile_scale(model.system_gain, signal_range=to.signal_range),
        source="DNG",
    ),
    Definition(
        quantity="noise_profile_offset",
        unit=ONE,
        symbol="O",
        equation="A / (white - black)^2",
        formula=lambda model, to: conversions.noise_profile_offset(model.dark_dn2, signal_range=to.signal_range),
        source="DNG",
    ),
)
