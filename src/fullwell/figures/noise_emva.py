"""The figures of a noise model that EMVA 1288 asks for; a rescaled file's DN are brought back to codes."""

import math
from typing import Final

from fullwell.figures.noise_definition import Definition, dark_electrons, decibel, saturation_e, times
from fullwell.figures.noise_model import Conventions, NativeModel
from fullwell.model import conversions
from fullwell.units import DECIBEL, DN, DN_PER_ELECTRON, ELECTRON, ELECTRON_PER_SECOND, PERCENT


def _temporal_electrons2(model: NativeModel, to: Conventions) -> float:
    """Return the temporal variance in the dark with rounding left in [e-^2]."""
    return conversions.unlit_electrons2(
        model.read_e2,
        system_gain=model.system_gain,
        dark_electrons=dark_electrons(model, to),
        step=to.step,
    )


def _linear_threshold(model: NativeModel, to: Conventions) -> float:
    return conversions.sensitivity_threshold(max(_temporal_electrons2(model, to), 0.0))


def _reference_threshold(model: NativeModel, to: Conventions) -> float:
    return conversions.reference_sensitivity_threshold(max(_temporal_electrons2(model, to), 0.0))


def _linear_range(model: NativeModel, to: Conventions) -> float | None:
    return decibel(saturation_e(model, to) / _linear_threshold(model, to))


def _reference_range(model: NativeModel, to: Conventions) -> float | None:
    return decibel(saturation_e(model, to) / _reference_threshold(model, to))


BY_EMVA: Final = (
    Definition(
        quantity="system_gain",
        unit=DN_PER_ELECTRON,
        symbol="K",
        equation="D k_shot^2 / q",
        formula=lambda model, to: model.system_gain / to.step,
        source="EMVA1288 4.0",
    ),
    Definition(
        quantity="temporal_dark_noise",
        unit=DN,
        symbol="sigma_y.dark",
        equation="sqrt(K^2 sigma_d^2 + q^2/12) / q",
        formula=lambda model, to: _temporal_electrons2(model, to) * (model.system_gain / to.step) ** 2,
        source="EMVA1288 4.0",
        root=True,
        rests_on=frozenset({"split", "rounding"}),
    ),
    Definition(
        quantity="dark_noise",
        unit=ELECTRON,
        symbol="sigma_d",
        equation="sqrt(sigma_read^2 + i t)",
        formula=lambda model, to: model.read_e2 + dark_electrons(model, to),
        source="EMVA1288 4.0",
        root=True,
        rests_on=frozenset({"split", "rounding"}),
    ),
    Definition(
        quantity="dsnu",
        unit=ELECTRON,
        symbol="DSNU",
        equation="DSNU",
        formula=lambda model, _: model.dsnu_e2,
        source="EMVA1288 4.0",
        root=True,
    ),
    Definition(
        quantity="prnu",
        unit=PERCENT,
        symbol="PRNU",
        equation="k_fpn at most",
        formula=lambda model, _: times(model.fixed, 1e4),
        source="EMVA1288 4.0",
        root=True,
        rests_on=frozenset({"fixed"}),
    ),
    Definition(
        quantity="dark_current",
        unit=ELECTRON_PER_SECOND,
        symbol="mu_I",
        equation="i",
        formula=lambda model, _: model.dark_current,
        source="EMVA1288 4.0",
    ),
    *(
        Definition(
            quantity="sensitivity_threshold",
            unit=ELECTRON,
            symbol="mu_e.min",
            equation=equation,
            formula=formula,
            method=method,
            source=source,
            rests_on=frozenset({"split", "rounding"}),
        )
        for method, source, equation, formula in (
            (
                "emva1288-4.0-linear",
                "EMVA1288 4.0",
                "sqrt(sigma_d^2 + q^2/12K^2 + 1/4) + 1/2",
                _linear_threshold,
            ),
            ("emva1288-py-1.0", "EMVA1288-PY", "sqrt(sigma_d^2 + q^2/12K^2) + 1/2", _reference_threshold),
        )
    ),
    Definition(
        quantity="saturation_capacity",
        unit=ELECTRON,
        symbol="mu_e.sat",
        equation="V_sat / k_shot^2",
        formula=saturation_e,
        source="EMVA1288 4.0",
        rests_on=frozenset({"saturation"}),
    ),
    Definition(
        quantity="snr_max",
        unit=DECIBEL,
        symbol="SNR_max",
        equation="sqrt(mu_e.sat)",
        formula=lambda model, to: decibel(math.sqrt(saturation_e(model, to))),
        method="emva1288-4.0-linear",
        source="EMVA1288 4.0",
        rests_on=frozenset({"saturation"}),
    ),
    *(
        Definition(
            quantity="dynamic_range",
            unit=DECIBEL,
            symbol="DR",
            equation="mu_e.sat / mu_e.min",
            formula=formula,
            method=method,
            source=source,
            rests_on=frozenset({"saturation", "split", "rounding"}),
        )
        for method, source, formula in (
            (
                "emva1288-4.0-linear",
                "EMVA1288 4.0",
                _linear_range,
            ),
            (
                "emva1288-py-1.0",
                "EMVA1288-PY",
                _reference_range,
            ),
        )
    ),
)
