"""Curves of one channel under one profile: columns of equal length after method, ISO, temperature and channel."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.results import Column, Curve
from fullwell.workflow.measure.bursts import IsoBursts

Values = NDArray[np.float64] | NDArray[np.int64] | NDArray[np.bool_] | tuple[str, ...] | None
Columns = Iterable[tuple[str, str, Values]]


def table(name: str, bursts: IsoBursts, channel: str, *, method: str, steps: int, columns: Columns) -> Curve:
    """Return a curve.

    Parameters
    ----------
    name
        As in docs/emva1288.md.
    bursts, channel, method
        What it belongs to.
    steps
        Rows.
    columns
        Name, unit, values; None for a column without any, flags become 1 and 0, what is not finite null.

    """
    return Curve(
        name=name,
        columns=(
            Column(name="method", unit="", values=(method,) * steps),
            Column(name="iso", unit="1", values=(bursts.iso,) * steps),
            Column(name="temperature_c", unit="degC", values=(bursts.temperature_c,) * steps),
            Column(name="channel", unit="", values=(channel,) * steps),
            *(Column(name=title, unit=unit, values=_plain(values, steps)) for title, unit, values in columns),
        ),
    )


def _plain(values: Values, steps: int) -> tuple[float | int | str | None, ...]:
    if values is None:
        return (None,) * steps
    if isinstance(values, tuple):
        return values
    if values.dtype.kind == "b":
        values = values.astype(np.int64)
    if values.dtype.kind == "f" and not np.isfinite(values).all():
        return tuple(value if math.isfinite(value) else None for value in values.tolist())
    return tuple(values.tolist())
