"""The coefficients of shading models as a table, with their errors."""

import csv
import io
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from fullwell.fit.shading.surface import ShadingModel
from fullwell.workflow.measure.shading import BurstShading

_COLUMNS: Final = ("iso", "exposure_s", "channel", "model", "chosen", "parameter", "value", "std_error")
_PUBLISHED: Final = "poly22"
_POWERS: Final = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_PLACES: Final = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)])
"""Six places that determine a polynomial of degree two, as fractions of the plane."""
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


def published_coefficients(model: ShadingModel) -> tuple[tuple[str, float, float], ...]:
    """Return name, value and standard error of p00, p10, p01, p20, p11, p02 of a polynomial of degree two.

    Parameters
    ----------
    model
        A ``poly22``; x is the row and y the column of its plane, counted from 1 [DN, DN/pixel, DN/pixel^2].

    """
    size = np.asarray(model.plane_shape, dtype=np.float64)
    values, covariance = model.surface_and_covariance(*(_PLACES * size - 1.0).T)
    solve = np.linalg.inv(np.stack([_PLACES[:, 0] ** x * _PLACES[:, 1] ** y for x, y in _POWERS], axis=1))
    solve /= np.array([size[0] ** x * size[1] ** y for x, y in _POWERS])[:, np.newaxis]
    errors = np.sqrt(np.maximum(np.diag(solve @ covariance @ solve.T), 0.0))
    names = (f"p{x}{y}" for x, y in _POWERS)
    return tuple(zip(names, (solve @ values).tolist(), errors.tolist(), strict=True))


def _lines(model: ShadingModel) -> Iterator[tuple[str, str, str]]:
    if model.name == _UNLISTED:
        return
    named = published_coefficients(model) if model.name == _PUBLISHED else _plain(model)
    for name, value, error in named:
        yield name, f"{value:.12g}", f"{error:.6g}"


def _plain(model: ShadingModel) -> Iterator[tuple[str, float, float]]:
    for index, (name, value) in enumerate(zip(model.parameter_names, model.values, strict=True)):
        yield name, float(value), math.sqrt(max(float(model.covariance[index, index]), 0.0))
