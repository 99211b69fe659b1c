"""Curves of the sweep and the darks: what the standard's plots show, and their data tables."""

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.package import PackageFigures
from fullwell.figures.emva1288.sensitivity import snr_model, threshold_electrons
from fullwell.figures.emva1288.sweep import Floats, Sweep
from fullwell.figures.results import Curve
from fullwell.units import DN, DN2, ONE, PERCENT
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.linear import LinearFits
from fullwell.workflow.measure.emva.steps import DarkSeries
from fullwell.workflow.measure.emva.tables import Columns, table
from fullwell.workflow.measure.emva.writer import LINEAR, PACKAGE

_MODEL_POINTS = 101
_MOST_CUT = 0.5


class _Writer:
    """Writes curves of one channel."""

    def __init__(self, bursts: IsoBursts, channel: str, method: str) -> None:
        self._bursts, self._channel, self._method = bursts, channel, method

    def curve(self, name: str, steps: int, columns: Columns) -> Curve:
        return table(name, self._bursts, self._channel, method=self._method, steps=steps, columns=columns)


def sweep_curves(
    bursts: IsoBursts, channel: str, fits: LinearFits, *, pattern: tuple[float, float] = (0.0, 0.0)
) -> tuple[Curve, ...]:
    """Return the curves of Release 4.0 Linear.

    Parameters
    ----------
    bursts, channel, fits
        What was measured.
    pattern
        Fixed pattern for the model of the total signal-to-noise ratio: variance in the dark [DN^2], and relative
        variance of the response.

    """
    writer, sweep = _Writer(bursts, channel, LINEAR), fits.sweep
    gain = None if fits.system_gain is None else fits.system_gain.line
    fitted_variance = None if gain is None else gain.at(sweep.signal)
    response = None if fits.response is None or sweep.exposure is None else fits.response.value * sweep.exposure
    curves = [
        _sweep(writer, sweep, in_range=fits.in_range, in_linearity=fits.in_linearity, saturation=_nearest(fits)),
        _characteristic(writer, sweep, response, fits.in_range),
        _stability(writer, sweep),
        _transfer(writer, sweep, fitted_variance, fits.in_range, _nearest(fits)),
        _snr(writer, sweep),
        _dark_current(writer, fits.darks),
    ]
    if sweep.varies_time:
        curves.append(_dark_mean(writer, sweep))
    if fits.linearity is not None and sweep.exposure is not None:
        line = fits.linearity
        fitted = line.offset + line.slope * sweep.exposure
        deviation = 100.0 * (sweep.signal - fitted) / fitted
        errors = np.full(sweep.steps, np.nan)
        errors[fits.in_linearity] = line.deviation_error
        curves.append(_linearity(writer, sweep, fitted, (deviation, errors), fits.in_linearity))
    model = _snr_model(writer, fits, pattern)
    return (*curves, model) if model is not None else tuple(curves)


def package_curves(bursts: IsoBursts, channel: str, sweep: Sweep, found: PackageFigures) -> tuple[Curve, ...]:
    """Return the curves of the package's sweep."""
    writer, steps = _Writer(bursts, channel, PACKAGE), np.arange(sweep.steps)
    in_range = steps <= found.fit_last
    in_linearity = (steps >= found.linearity_first) & (steps <= found.linearity_last)
    saturation = steps == found.saturation
    response = None if sweep.photons is None else found.responsivity * sweep.photons
    curves = [
        _sweep(writer, sweep, in_range=in_range, in_linearity=in_linearity, saturation=saturation),
        _characteristic(writer, sweep, response, in_range),
        _transfer(writer, sweep, found.system_gain * sweep.signal, in_range, saturation),
        _snr(writer, sweep),
    ]
    if found.linearity_offset is not None and found.linearity_slope is not None and sweep.photons is not None:
        fitted = found.linearity_offset + found.linearity_slope * sweep.photons
        deviation = (100.0 * (sweep.signal - fitted) / fitted, np.full(sweep.steps, np.nan))
        curves.append(_linearity(writer, sweep, fitted, deviation, in_linearity))
    return tuple(curves)


def _nearest(fits: LinearFits) -> NDArray[np.bool_]:
    """Return which step is nearest to saturation."""
    distance = np.abs(fits.sweep.mean - fits.saturation.mean)
    return np.arange(fits.sweep.steps) == int(np.argmin(distance))


def _sweep(
    writer: _Writer,
    sweep: Sweep,
    *,
    in_range: NDArray[np.bool_],
    in_linearity: NDArray[np.bool_],
    saturation: NDArray[np.bool_],
) -> Curve:
    snr, snr_total = _measured_snr(sweep)
    return writer.curve(
        "emva_sweep",
        sweep.steps,
        (
            ("exposure_s", "s", sweep.exposure_s),
            ("photons", "p", sweep.photons),
            ("signal", DN, sweep.signal),
            ("mean", DN, sweep.mean),
            ("dark_mean", DN, sweep.dark_mean),
            ("variance_total", DN2, sweep.variance),
            ("dark_variance", DN2, sweep.dark_variance),
            ("variance", DN2, sweep.light_variance),
            ("variance_std_error", DN2, sweep.light_variance_error),
            ("noise", DN, np.sqrt(sweep.variance)),
            ("mean_difference", DN, sweep.mean_difference),
            ("spatial_variance", DN2, sweep.spatial_variance),
            ("top_fraction", ONE, sweep.top_fraction),
            ("snr", ONE, snr),
            ("snr_total", ONE, snr_total),
            ("in_range", ONE, in_range),
            ("in_linearity", ONE, in_linearity),
            ("saturation", ONE, saturation),
        ),
    )


def _characteristic(writer: _Writer, sweep: Sweep, fitted: Floats | None, in_range: NDArray[np.bool_]) -> Curve:
    return writer.curve(
        "emva_characteristic",
        sweep.steps,
        (
            ("photons", "p", sweep.photons),
            ("exposure_s", "s", sweep.exposure_s),
            ("signal", DN, sweep.signal),
            ("fitted", DN, fitted),
            ("in_range", ONE, in_range),
        ),
    )


def _dark_mean(writer: _Writer, sweep: Sweep) -> Curve:
    columns = (
        ("exposure_s", "s", sweep.exposure_s),
        ("dark_mean", DN, sweep.dark_mean),
        ("measured", ONE, sweep.dark_measured),
    )
    return writer.curve("emva_dark_mean", sweep.steps, columns)


def _stability(writer: _Writer, sweep: Sweep) -> Curve:
    columns = (
        ("signal", DN, sweep.signal),
        ("noise", DN, np.sqrt(sweep.variance)),
        ("mean_difference", DN, sweep.mean_difference),
    )
    return writer.curve("emva_stability", sweep.steps, columns)


def _transfer(
    writer: _Writer,
    sweep: Sweep,
    fitted: Floats | None,
    in_range: NDArray[np.bool_],
    saturation: NDArray[np.bool_],
) -> Curve:
    return writer.curve(
        "emva_photon_transfer",
        sweep.steps,
        (
            ("signal", DN, sweep.signal),
            ("variance", DN2, sweep.light_variance),
            ("variance_total", DN2, sweep.variance),
            ("dark_variance", DN2, sweep.dark_variance),
            ("variance_std_error", DN2, sweep.light_variance_error),
            ("fitted", DN2, fitted),
            ("in_range", ONE, in_range),
            ("saturation", ONE, saturation),
        ),
    )


def _measured_snr(sweep: Sweep) -> tuple[Floats, Floats]:
    """Return the signal over the temporal noise, (20), and over that with the fixed pattern of the same step.

    Unknown where most pixels are at the highest code: their noise is cut off.
    """
    cut = sweep.top_fraction > _MOST_CUT
    with np.errstate(divide="ignore", invalid="ignore"):
        temporal, total = (
            np.where(cut, np.nan, sweep.signal / np.sqrt(variance))
            for variance in (sweep.variance, sweep.variance + sweep.spatial_variance)
        )
    return temporal, total


def _snr(writer: _Writer, sweep: Sweep) -> Curve:
    snr, snr_total = _measured_snr(sweep)
    columns = (
        ("photons", "p", sweep.photons),
        ("exposure_s", "s", sweep.exposure_s),
        ("snr", ONE, snr),
        ("snr_total", ONE, snr_total),
    )
    return writer.curve("emva_snr", sweep.steps, columns)


def _snr_model(writer: _Writer, fits: LinearFits, pattern: tuple[float, float]) -> Curve | None:
    """Return the models from half the sensitivity threshold to saturation, equally spaced in their logarithm."""
    gain, response, saturation = fits.system_gain, fits.response, fits.saturation.exposure
    if gain is None or response is None or saturation is None or not fits.by_photons:
        return None
    efficiency = response.value / gain.line.slope
    variance = fits.dark_variance.value
    first = 0.5 * threshold_electrons((variance, gain.line.slope)) / efficiency
    photons = np.geomspace(first, max(saturation, 2.0 * first), _MODEL_POINTS)
    electrons, dark_e2 = efficiency * photons, variance / gain.line.slope**2
    dsnu_e2, prnu = max(pattern[0], 0.0) / gain.line.slope**2, max(pattern[1], 0.0) ** 0.5
    columns = (
        ("photons", "p", photons),
        ("snr", ONE, snr_model(electrons, dark_e2=dark_e2)),
        ("snr_total", ONE, snr_model(electrons, dark_e2=dark_e2, dsnu_e2=dsnu_e2, prnu=prnu)),
        ("ideal", ONE, np.sqrt(photons)),
    )
    return writer.curve("emva_snr_model", _MODEL_POINTS, columns)


def _linearity(
    writer: _Writer, sweep: Sweep, fitted: Floats, deviation: tuple[Floats, Floats], in_range: NDArray[np.bool_]
) -> Curve:
    return writer.curve(
        "emva_linearity",
        sweep.steps,
        (
            ("photons", "p", sweep.photons),
            ("exposure_s", "s", sweep.exposure_s),
            ("signal", DN, sweep.signal),
            ("fitted", DN, fitted),
            ("deviation", PERCENT, deviation[0]),
            ("deviation_std_error", PERCENT, deviation[1]),
            ("in_range", ONE, in_range),
        ),
    )


def _dark_current(writer: _Writer, darks: DarkSeries) -> Curve:
    lines = darks.lines
    fitted = (None, None) if lines is None else tuple(line.at(darks.exposure_s) for line in lines)
    return writer.curve(
        "emva_dark_current",
        darks.exposure_s.size,
        (
            ("exposure_s", "s", darks.exposure_s),
            ("dark_mean", DN, darks.mean),
            ("dark_mean_fitted", DN, fitted[0]),
            ("dark_variance", DN2, darks.variance),
            ("dark_variance_fitted", DN2, fitted[1]),
        ),
    )
