"""The coefficients of shading models as a table, with their errors."""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from typing import Final

from fullwell.fit.shading.polynomial import monomial_coefficients
from fullwell.fit.shading.surface import ShadingModel
from fullwell.workflow.measure.shading import BurstShading

_COLUMNS: Final = ("iso", "exposure_s", "channel", "model", "chosen", "parameter", "value", "std_error")
_PUBLISHED: Final = "poly22"
_UNLISTED: Final = "p-spline"
"""Its coefficients mean nothing one by one; the map files hold them."""


def coefficients_csv(bursts: Sequence[BurstShading]) -> str:
    """Return a table with every coefficient of every model, but for the spline's: value and standard error.

    Those of ``poly22`` are as the published study writes them: p10 belongs to x, p01 to y, where x is the row and y
    the column of the plane, both counted from 1. Here black is subtracted and bins are weighted (METHOD 6.1).
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for burst in bursts:
        where = ("" if burst.iso is None else f"{burst.iso:g}", f"{burst.burst.exposure_s:.12g}")
        for one in burst.channels:
            for model in one.fits.models.values():
                chosen = "yes" if model.name == one.fits.chosen else "no"
                writer.writerows((*where, one.channel, model.name, chosen, *line) for line in _lines(model))
    return text.getvalue()


def _lines(model: ShadingModel) -> Iterator[tuple[str, str, str]]:
    if model.name == _UNLISTED:
        return
    named = monomial_coefficients(model) if model.name == _PUBLISHED else _plain(model)
    for name, value, error in named:
        yield name, f"{value:.12g}", f"{error:.6g}"


def _plain(model: ShadingModel) -> Iterator[tuple[str, float, float]]:
    for index, (name, value) in enumerate(zip(model.parameter_names, model.values, strict=True)):
        yield name, float(value), math.sqrt(max(float(model.covariance[index, index]), 0.0))
