"""Linearity error: how far the response strays from a straight line, relative (EMVA1288 4)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.figures.emva1288.sweep import Floats

RANGE: Final = (0.05, 0.95)
"""Share of the saturation between which linearity is judged."""

FEWEST_STEPS: Final = 9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Linearity:
    """A line fitted with weight 1/y^2 and what the steps stray from it.

    Parameters
    ----------
    offset, slope
        a0 [DN] and a1 [DN per exposure].
    offset_error, slope_error
        From the noise of the pixels.
    deviation
        Of every step in the range [%].
    deviation_error
        From the noise of the pixels [%].

    """

    offset: float
    slope: float
    offset_error: float
    slope_error: float
    deviation: Floats
    deviation_error: Floats

    @property
    def error(self) -> float:
        """Return LE, (63) [%]."""
        return float(np.abs(self.deviation).mean())

    @property
    def floor(self) -> float:
        """Return what noise alone would make of LE [%]."""
        return float(np.sqrt(2.0 / np.pi) * self.deviation_error.mean())

    @property
    def error_error(self) -> float:
        """Return the standard error of LE, steps taken as independent [%]."""
        return float(np.sqrt(np.sum(self.deviation_error**2))) / self.deviation.size


def linearity_range(signal: Floats, *, saturation_signal: float) -> NDArray[np.bool_]:
    """Return the steps between 5 and 95 % of saturation."""
    low, high = (share * saturation_signal for share in RANGE)
    return (signal >= low) & (signal <= high)


def measure_linearity(exposure: Floats, signal: Floats, signal_error: Floats) -> Linearity | None:
    """Fit the line of (58) to (61); None where fewer than two steps differ.

    Parameters
    ----------
    exposure
        Photons or exposure time of the steps in the range.
    signal, signal_error
        Mean above dark and its standard error [DN].

    Examples
    --------
    >>> found = measure_linearity(np.arange(1000.0, 5001, 1000), np.array([101.0, 199, 302, 398, 505]), np.ones(5))
    >>> round(found.offset, 9), round(found.slope, 9), round(found.error, 9)
    (0.686460021, 0.100011078, 0.621844474)

    """
    if exposure.size < 2 or np.ptp(exposure) == 0.0 or np.any(signal <= 0.0):
        return None
    design = np.stack((1.0 / signal, exposure / signal), axis=1)
    scale = np.array([1.0, 1.0 / float(np.abs(exposure).max())])
    solver = np.linalg.pinv(design * scale) * scale[:, np.newaxis]
    offset, slope = (float(value) for value in solver @ np.ones_like(signal))
    relative = signal_error / signal
    offset_error, slope_error = (float(value) for value in np.sqrt((solver * relative) ** 2 @ np.ones_like(signal)))
    fitted = offset + slope * exposure
    left = np.eye(exposure.size) - design @ solver
    return Linearity(
        offset=offset,
        slope=slope,
        offset_error=offset_error,
        slope_error=slope_error,
        deviation=100.0 * (signal - fitted) / fitted,
        deviation_error=100.0 * np.sqrt((left * relative) ** 2 @ np.ones_like(signal)),
    )
