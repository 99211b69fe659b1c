"""Writes the rows of one channel under one profile."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from fullwell.figures.emva1288.sweep import Floats
from fullwell.figures.propagation import Ingredient, propagated
from fullwell.figures.results import Row
from fullwell.units import Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.section import RowWriter

LINEAR = "emva1288-4.0-linear"
CORRECTED = "emva1288-4.0-linear-hp-corrected"
PACKAGE = "emva1288-py-1.0"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelWriter:
    """Collects rows of one channel.

    Parameters
    ----------
    bursts, channel, method
        What every row has in common.
    source
        Bibliography key; equations are added to it.

    """

    bursts: IsoBursts
    channel: str
    method: str
    source: str = "EMVA1288"
    rows: list[Row] = field(default_factory=list[Row])

    def add(
        self,
        quantity: str,
        measured: Measured | None,
        *,
        equation: str,
        n: int | None = None,
        flags: Sequence[str] = (),
        snr: float | None = None,
        exposure_s: float | None = None,
    ) -> None:
        """Add a row, unless there is nothing to say."""
        if measured is None or not np.isfinite(measured.value):
            return
        write = RowWriter(bursts=self.bursts).row
        self.rows.append(
            write(
                quantity,
                self.channel,
                self.method,
                measured,
                source=f"{self.source} {equation}",
                n=n,
                flags=flags,
                snr_threshold=snr,
                exposure_s=exposure_s,
            )
        )

    def add_root(
        self,
        quantity: str,
        variance: Measured,
        unit: str,
        *,
        equation: str,
        n: int | None = None,
        flags: Sequence[str] = (),
    ) -> None:
        """Add a square root and its signed twin."""
        write = RowWriter(bursts=self.bursts).root_and_variance
        self.rows.extend(
            write(
                quantity,
                self.channel,
                self.method,
                variance,
                unit,
                source=f"{self.source} {equation}",
                n=n,
                flags=flags,
                recommended=False,
            )
        )


def derived(function: Callable[[Floats], float], *ingredients: Measured | None, unit: str) -> Measured | None:
    """Return a figure computed from independent others, None where one of them is missing or it is not a number.

    Parameters
    ----------
    function
        Of the ingredients' values, shape (N,).
    *ingredients
        What it is computed from.
    unit
        Of the figure.

    """
    known = [one for one in ingredients if one is not None]
    if len(known) < len(ingredients):
        return None
    return propagated(function, [Ingredient(measured=one) for one in known], unit=unit)
