"""Saturation: where 0.1 to 0.2 % of the pixels lie at the highest code (EMVA1288 3.1)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import ndtri

from fullwell.figures.emva1288.sweep import Floats, Sweep

WINDOW: Final = (0.001, 0.002)
"""Fraction of pixels at the highest code."""

_AIM: Final = 0.0015
_MOST: Final = 0.3
"""Fraction above which the tail says nothing of the distance to the highest code."""

_FALL: Final = 0.5
"""Share of its peak to which the variance falls where a full well saturates without a code of its own."""

_FEWEST: Final = 10
"""Pixel values at the highest code that a fraction needs at least."""

_Z_AIM: Final = float(-ndtri(_AIM))
_Z_WINDOW: Final = (float(-ndtri(WINDOW[1])), float(-ndtri(WINDOW[0])))


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation:
    """Where the sweep saturates.

    Parameters
    ----------
    mean
        Mean raw value there [DN].
    exposure
        Photons, or exposure time, there; None where the sweep has no abscissa.
    signal
        Mean above dark there [DN].
    mean_error, exposure_error, signal_error
        Standard errors: the window of the rule taken as uniform, and the counts.
    mode
        ``probe`` where a step lies in the window, ``interpolated`` between steps, ``bracketed`` where the fraction
        jumps and the noise below tells the place, ``peak`` where no code piles up but the noise falls again, as at a
        full well below the converter's range, ``unreached`` where nothing saturates.
    bracket
        The steps around it; the same twice for a probe.

    """

    mean: float
    exposure: float | None
    signal: float
    mean_error: float | None
    exposure_error: float | None
    signal_error: float | None
    mode: str
    bracket: tuple[int, int]


def find_saturation(sweep: Sweep, *, top_code: float | None, values_per_step: Floats) -> Saturation:
    """Find the saturation of a sweep.

    Parameters
    ----------
    sweep
        By ascending exposure.
    top_code
        The highest code, where values pile up; None where they never do [DN].
    values_per_step
        Pixel values behind each ``top_fraction``.

    """
    order = np.argsort(sweep.mean)
    fraction = sweep.top_fraction
    if top_code is None or not np.any(fraction > WINDOW[0]):
        peak, last = int(np.argmax(sweep.variance)), int(order[-1])
        falls = bool(sweep.variance[sweep.mean >= sweep.mean[peak]].min() < _FALL * sweep.variance[peak])
        return _at_step(sweep, peak if falls else last, mode="peak" if falls else "unreached")
    inside = [int(i) for i in order if WINDOW[0] <= fraction[i] <= WINDOW[1]]
    if inside:
        return _at_step(sweep, min(inside, key=lambda i: abs(fraction[i] - _AIM)), mode="probe")
    upper = next(int(i) for i in order if fraction[i] > WINDOW[1])
    below = [int(i) for i in order[: int(np.flatnonzero(order == upper)[0])]]
    if not below:
        return _at_step(sweep, upper, mode="unreached")
    lower = below[-1]
    counted = fraction[lower] * values_per_step[lower] >= _FEWEST and fraction[upper] < _MOST
    if counted:
        z = -ndtri(fraction[[lower, upper]])
        share = float((z[0] - _Z_AIM) / (z[0] - z[1]))
        width = abs(_Z_WINDOW[0] - _Z_WINDOW[1]) / (z[0] - z[1])
        return _between(sweep, lower, upper, share=share, width=float(width), mode="interpolated")
    return _by_noise(sweep, lower, upper, top_code=top_code)


def _at_step(sweep: Sweep, step: int, *, mode: str) -> Saturation:
    exposure = sweep.exposure
    error = float(np.sqrt(sweep.variance[step]) * (_Z_WINDOW[1] - _Z_WINDOW[0]) / np.sqrt(12.0))
    slope = None if exposure is None or sweep.signal[step] <= 0.0 else float(exposure[step] / sweep.signal[step])
    known = mode == "probe"
    return Saturation(
        mean=float(sweep.mean[step]),
        exposure=None if exposure is None else float(exposure[step]),
        signal=float(sweep.signal[step]),
        mean_error=error if known else None,
        exposure_error=error * slope if known and slope is not None else None,
        signal_error=error if known else None,
        mode=mode,
        bracket=(step, step),
    )


def _between(sweep: Sweep, lower: int, upper: int, *, share: float, width: float, mode: str) -> Saturation:
    """Return the place at a share of the way between two steps; ``width`` of the way is as good."""
    uncertain = width / np.sqrt(12.0)

    def mixed(values: Floats) -> tuple[float, float]:
        step = float(values[upper] - values[lower])
        return float(values[lower]) + share * step, abs(step) * float(uncertain)

    mean, mean_error = mixed(sweep.mean)
    signal, signal_error = mixed(sweep.signal)
    exposure = None if sweep.exposure is None else mixed(sweep.exposure)
    return Saturation(
        mean=mean,
        exposure=None if exposure is None else exposure[0],
        signal=signal,
        mean_error=mean_error,
        exposure_error=None if exposure is None else exposure[1],
        signal_error=signal_error,
        mode=mode,
        bracket=(lower, upper),
    )


def _by_noise(sweep: Sweep, lower: int, upper: int, *, top_code: float) -> Saturation:
    """Return the place where the noise seen below would put the aimed fraction at the highest code.

    Shot noise grows with the signal, so the noise there is a little more than at the step below. The place lies
    between the steps, whatever the noise says.
    """
    spatial = max(0.0, float(np.nan_to_num(sweep.spatial_variance[lower])))
    dark = max(0.0, float(sweep.dark_variance[lower]))
    total = float(sweep.variance[lower]) + spatial
    signal = max(float(sweep.signal[lower]), 1e-9)
    dark_mean = float(sweep.dark_mean[lower])
    place, noise = signal, 0.0
    for _ in range(50):
        noise = math.sqrt(dark + max(total - dark, 0.0) * place / signal)
        place = top_code - 0.5 - _Z_AIM * noise - dark_mean
    place = min(max(place, signal), float(sweep.mean[upper]) - dark_mean)
    stretch = place / signal
    exposure = None if sweep.exposure is None else float(sweep.exposure[lower]) * stretch
    half = 0.5 * abs(float(sweep.signal[upper]) - signal) / np.sqrt(3.0)
    error = float(min(half, noise))
    return Saturation(
        mean=place + dark_mean,
        exposure=exposure,
        signal=place,
        mean_error=error,
        exposure_error=None if exposure is None else exposure * error / place,
        signal_error=error,
        mode="bracketed",
        bracket=(lower, upper),
    )
