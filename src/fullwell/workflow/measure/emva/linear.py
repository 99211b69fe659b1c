"""The sweep of one channel evaluated by Release 4.0 Linear: fits first, figures from them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.linearity import Linearity, linearity_range, measure_linearity
from fullwell.figures.emva1288.saturation import Saturation, find_saturation
from fullwell.figures.emva1288.sensitivity import (
    SystemGain,
    dark_variance,
    fit_range,
    fit_responsivity,
    fit_system_gain,
)
from fullwell.figures.emva1288.spline_gate import SplineGate, spline_gate
from fullwell.figures.emva1288.sweep import Floats, Sweep
from fullwell.units import Measured
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.steps import DarkSeries, dark_series, sweep_of, values_per_step


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearFits:
    """What Release 4.0 Linear fits to one channel.

    Parameters
    ----------
    sweep, darks
        What was measured.
    saturation
        Where the sweep ends.
    in_range, in_linearity
        Steps up to 70 %, and between 5 and 95 %, of saturation.
    system_gain
        None where the steps are too few or the line does not rise.
    response
        Slope of the signal against photons, or against time where photons are unknown [DN/p, DN/s].
    dark_variance, floored
        Of the shortest exposure, and whether it is the limit that quantization sets.
    gate, linearity
        None where the steps are too few.

    """

    sweep: Sweep
    darks: DarkSeries
    saturation: Saturation
    in_range: NDArray[np.bool_]
    in_linearity: NDArray[np.bool_]
    system_gain: SystemGain | None
    response: Measured | None
    dark_variance: Measured
    floored: bool
    gate: SplineGate | None
    linearity: Linearity | None

    @property
    def by_photons(self) -> bool:
        """Return whether the abscissa is in photons."""
        return self.sweep.photons is not None

    @property
    def saturation_exposure(self) -> Measured | None:
        """Return where the sweep saturates [p, s]; None without an abscissa."""
        unit = "p" if self.by_photons else "s"
        return _measured(self.saturation.exposure, self.saturation.exposure_error, unit)

    @property
    def saturation_level(self) -> Measured:
        """Return the mean raw value where the sweep saturates [DN]."""
        found = _measured(self.saturation.mean, self.saturation.mean_error, "DN")
        return found or Measured.exact(self.saturation.mean, "DN")


def _measured(value: float | None, error: float | None, unit: str) -> Measured | None:
    if value is None:
        return None
    return Measured.exact(value, unit) if error is None else Measured.normal(value, error, unit)


def fit_linear(bursts: IsoBursts, channel: str, *, top_code: float | None) -> LinearFits | None:
    """Fit one channel; None where there are no pairs of flats or no darks.

    Parameters
    ----------
    bursts
        All of one ISO.
    channel
        Which.
    top_code
        The code at which values pile up; None where they never do [DN].

    """
    darks = dark_series(bursts, channel)
    sweep = None if darks is None else sweep_of(bursts, channel, darks, top_code=top_code)
    if darks is None or sweep is None:
        return None
    values = np.full(sweep.steps, values_per_step(bursts, channel))
    saturation = find_saturation(sweep, top_code=top_code, values_per_step=values)
    in_range = fit_range(sweep, saturation_signal=saturation.signal)
    system_gain = fit_system_gain(sweep, in_range)
    if system_gain is not None and system_gain.line.slope <= 0.0:
        system_gain = None
    exposure = sweep.exposure
    variance, floored = dark_variance(darks.lowest.temporal_variance, darks.lowest.n)
    in_linearity = linearity_range(sweep.signal, saturation_signal=saturation.signal)
    return LinearFits(
        sweep=sweep,
        darks=darks,
        saturation=saturation,
        in_range=in_range,
        in_linearity=in_linearity,
        system_gain=system_gain,
        response=None if exposure is None else _response(exposure, sweep, in_range),
        dark_variance=variance,
        floored=floored,
        gate=None
        if system_gain is None
        else spline_gate(sweep, in_range, line=system_gain.line, saturation_signal=saturation.signal),
        linearity=None if exposure is None else _linearity(exposure, sweep, in_linearity),
    )


def _response(exposure: Floats, sweep: Sweep, in_range: NDArray[np.bool_]) -> Measured | None:
    found = fit_responsivity(exposure, sweep, in_range)
    unit = "DN/s" if sweep.photons is None else "DN/p"
    return None if found is None or found[0] <= 0.0 else Measured.normal(*found, unit)


def _linearity(exposure: Floats, sweep: Sweep, chosen: NDArray[np.bool_]) -> Linearity | None:
    return measure_linearity(exposure[chosen], sweep.signal[chosen], sweep.signal_error[chosen])
