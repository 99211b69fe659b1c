"""Why a published figure is off, each in a sentence."""

from typing import Final

from fullwell import glossary
from fullwell.units import VOLT

_REASONS: Final = {
    "legacy-slope-std": "Temporal noise is left in the spread of the slopes: tiles take out shading, not noise.",
    "legacy-intercept-std": "The spread of the intercepts is mostly temporal noise, drawn out to no exposure.",
    "legacy-std-intercept": (
        "The standard deviation of a lit frame mixes channels, shading and shot noise; no line leads to the dark."
    ),
    "legacy-poly22": (
        "A polynomial of degree two is too stiff for the corners; the pedestal left in makes the shading look weaker."
    ),
    "legacy-pair-difference": "Right but for the rounding of the converter, which is left in.",
    "legacy-burst-mean": "The mean of n frames holds a share of each: low by √((n−1)/n), 10.6 % for five.",
    "legacy-frame-slope": "Not biased, but taken from single frames and without an error that holds.",
}
_WHOLE_CROP: Final = "Over the whole crop the shading that the map misses counts too."
_CHANNELS: Final = {
    "G": "G: averaging G1 and G2 lowers green by √2.",
    "all": "All: the different responses of the colours count as non-uniformity.",
}
_MIXED: Final = frozenset({"legacy-slope-std", "legacy-intercept-std"})
_RESCALED: Final = "In volts: values divided by 65 535 were taken for raw values."


def reason(method: str, *, channels: frozenset[str], unit: str, whole_crop: bool) -> str:
    """Return why the figures of a published method are off.

    Parameters
    ----------
    method
        Name of the method.
    channels
        Those it was given for.
    unit
        Of the figures.
    whole_crop
        Whether they are of the study's whole crop rather than of its tiles.

    """
    entry = glossary.method(method)
    parts = [_REASONS.get(method) or (entry.bias if entry else "")]
    if method in _MIXED:
        parts += [_WHOLE_CROP] if whole_crop else []
        parts += [text for channel, text in _CHANNELS.items() if channel in channels]
    if method == "legacy-std-intercept" and unit == VOLT:
        parts.append(_RESCALED)
    return " ".join(part for part in parts if part)
