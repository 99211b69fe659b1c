"""Fixed pattern and lens shading: what differs from pixel to pixel and stays."""

from dataclasses import replace
from typing import Final

from fullwell.glossary.entry import Quantity

_DSNU: Final = Quantity(
    name="dsnu",
    title="DSNU",
    symbol="DSNU",
    units=("DN", "e-", "V"),
    definition="Dark-signal non-uniformity: spatial standard deviation of the dark signal, temporal noise removed.",
    equation="DSNU² = s²_dark − σ²/L",
    source="METHOD 5.1",
    signed_twin=True,
)
_PRNU: Final = Quantity(
    name="prnu",
    title="PRNU",
    symbol="PRNU",
    units=("%",),
    definition="Photo-response non-uniformity: relative spatial standard deviation of the response, shading removed.",
    equation="PRNU² = [RSS/(n−p) − σ²_flat/L_flat − σ²_dark/L_dark]/S²",
    source="METHOD 5.1",
    signed_twin=True,
)
_PARTS: Final = (
    ("row", "rows", "The part that all pixels of a row share."),
    ("column", "columns", "The part that all pixels of a column share."),
    ("pixel", "pixels", "The part that rows and columns do not explain."),
)


def _with_parts(whole: Quantity) -> tuple[Quantity, ...]:
    """Return a non-uniformity and its split into rows, columns and pixels."""
    parts = tuple(
        replace(
            whole,
            name=f"{whole.name}_{name}",
            title=f"{whole.title} of {plural}",
            symbol=f"{whole.symbol}_{name}",
            definition=f"{whole.definition} {sentence}",
            equation="two-way analysis of variance of the averaged frame",
            source="METHOD 3.5",
        )
        for name, plural, sentence in _PARTS
    )
    return (whole, *parts)


NONUNIFORMITY: Final = (*_with_parts(_DSNU), *_with_parts(_PRNU))

SHADING: Final = (
    Quantity(
        name="shading_corner",
        title="Corner shading",
        symbol="m_corner",
        units=("1",),
        definition="Response in the corners relative to the maximum of the fitted surface, mean of the four corners.",
        equation="m_corner = mean of the four corners of the map",
        source="METHOD 6.1",
    ),
    Quantity(
        name="shading_edge_x",
        title="Shading at the left and right edge",
        symbol="m_x",
        units=("1",),
        definition="Response at the middle of the left and right edge relative to the maximum of the fitted surface.",
        equation="m_x = mean of the map at both edges, middle row",
        source="METHOD 6.1",
    ),
    Quantity(
        name="shading_edge_y",
        title="Shading at the top and bottom edge",
        symbol="m_y",
        units=("1",),
        definition="Response at the middle of the top and bottom edge relative to the maximum of the fitted surface.",
        equation="m_y = mean of the map at both edges, middle column",
        source="METHOD 6.1",
    ),
    Quantity(
        name="shading_residual_rms",
        title="Residual of the shading model",
        symbol="ε_rms",
        units=("1",),
        definition="Root mean square of measured response over model, minus 1: what the shading model cannot describe.",
        equation="ε_rms = rms(response/model − 1)",
        source="METHOD 6.3",
    ),
)
