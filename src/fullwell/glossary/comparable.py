"""Which methods of one quantity have the same truth, and how the others differ from it."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final


class Kinship(StrEnum):
    """How two figures of one quantity by two methods are related."""

    SAME = "same truth"
    OTHER = "another definition"
    UNKNOWN = "not told"


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimand:
    """What some methods of a quantity have in common: the number they would all give with endless data."""

    quantity: str
    methods: tuple[str, ...]
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Whether two methods of a quantity may be compared, and in words why."""

    kinship: Kinship
    reason: str


TRUTH: Final = "truth"
"""Method of the values that a simulation was made with."""

_LINEAR: Final = "emva1288-4.0-linear"
_CORRECTED: Final = "emva1288-4.0-linear-hp-corrected"
_REFERENCE: Final = "emva1288-py-1.0"


def _patterns(quantity: str, plain: tuple[str, ...], legacy: tuple[str, ...]) -> tuple[Estimand, ...]:
    """Return the estimands of a fixed pattern, of the whole and of its parts."""
    names = (quantity, *(f"{quantity}_{part}" for part in ("row", "column", "pixel")))
    return tuple(
        estimand
        for name in names
        for estimand in (
            Estimand(
                quantity=name,
                methods=(*plain, _CORRECTED),
                what="the spatial standard deviation without temporal noise and slow shading",
            ),
            Estimand(
                quantity=name,
                methods=(_LINEAR,),
                what="what the high-pass of Release 4.0 leaves of it: 0.994 of white noise, 0.943 of rows and columns",
            ),
            Estimand(
                quantity=name, methods=(_REFERENCE,), what="the spatial standard deviation with all shading in it"
            ),
            Estimand(quantity=name, methods=legacy, what="the spatial standard deviation with temporal noise left in"),
        )
    )


ESTIMANDS: Final = (
    Estimand(
        quantity="system_gain",
        methods=("photon-transfer", _LINEAR, _REFERENCE, "conversion"),
        what="the slope of temporal variance against signal",
    ),
    Estimand(
        quantity="read_noise",
        methods=(
            "temporal-variance",
            "pair-difference",
            "censored-likelihood",
            "median-pixel",
            "conversion",
        ),
        what="temporal noise in the dark without rounding",
    ),
    Estimand(
        quantity="read_noise",
        methods=("legacy-pair-difference",),
        what="temporal noise in the dark with rounding left in",
    ),
    Estimand(
        quantity="read_noise",
        methods=("legacy-burst-mean",),
        what="temporal noise in the dark, low by the share of each frame in the mean",
    ),
    Estimand(
        quantity="dark_current",
        methods=("mean-slope", "legacy-frame-slope", _LINEAR, _REFERENCE),
        what="the slope of the mean dark signal against exposure time",
    ),
    Estimand(
        quantity="dark_current",
        methods=("variance-slope",),
        what="the slope of the dark variance, which an on-chip compensation does not hide",
    ),
    *_patterns("dsnu", ("dark-stack", "exposure-intercept"), ("legacy-intercept-std", "legacy-std-intercept")),
    *_patterns("prnu", ("flat-dark-stack", "exposure-slope", "two-framings"), ("legacy-slope-std",)),
    Estimand(
        quantity="saturation_capacity",
        methods=("temporal-variance-peak", _REFERENCE),
        what="the signal of the sweep at which temporal variance is largest",
    ),
    Estimand(
        quantity="saturation_capacity",
        methods=(_LINEAR,),
        what="the mean signal at which 0.1 to 0.2 % of the pixels stand at the highest code",
    ),
    Estimand(quantity="saturation_capacity", methods=("plateau",), what="the mean signal under heavy over-exposure"),
    Estimand(
        quantity="saturation_capacity",
        methods=("legacy-max-noise-patch",),
        what="the signal of the chart's patch with the largest total noise",
    ),
    Estimand(
        quantity="snr_max",
        methods=("shot-only", _LINEAR, _REFERENCE),
        what="the square root of the saturation capacity in electrons: photon noise alone",
    ),
    Estimand(
        quantity="snr_max", methods=("noise-model",), what="signal over all noise at saturation, fixed pattern included"
    ),
    Estimand(
        quantity="dynamic_range",
        methods=("noise-model",),
        what="saturation over the signal at which one frame, fixed pattern and all, reaches the threshold",
    ),
    Estimand(
        quantity="dynamic_range",
        methods=(_LINEAR,),
        what="saturation over the signal at which temporal noise alone gives SNR 1, solved exactly",
    ),
    Estimand(
        quantity="dynamic_range",
        methods=(_REFERENCE,),
        what="saturation over the dark noise and half an electron",
    ),
    Estimand(
        quantity="dynamic_range",
        methods=("legacy-patch",),
        what="the same by densities of the chart's patches nearest to the ends",
    ),
)


def comparability(quantity: str, first: str, second: str) -> Verdict:
    """Tell how a quantity by two methods is related.

    Examples
    --------
    >>> comparability("system_gain", "photon-transfer", "emva1288-4.0-linear").kinship.value
    'same truth'
    >>> comparability("snr_max", "noise-model", "emva1288-4.0-linear").kinship.value
    'another definition'

    """
    if TRUTH in {first, second}:
        return Verdict(kinship=Kinship.SAME, reason="One of the two is the truth of the simulation.")
    one, other = _estimand(quantity, first), _estimand(quantity, second)
    if one is None or other is None:
        return Verdict(kinship=Kinship.UNKNOWN, reason="")
    if one is other:
        return Verdict(kinship=Kinship.SAME, reason=f"Both estimate {one.what}.")
    return Verdict(kinship=Kinship.OTHER, reason=f"{first}: {one.what}. {second}: {other.what}.")


def _estimand(quantity: str, method: str) -> Estimand | None:
    name = quantity.removesuffix("_variance")
    return next((one for one in ESTIMANDS if one.quantity == name and method in one.methods), None)
