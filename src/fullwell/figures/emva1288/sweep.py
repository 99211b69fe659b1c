"""The exposure sweep: what the pairs of frames came to at every step (EMVA1288 2)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """Pairs of frames by ascending exposure; every array has shape (steps,).

    Parameters
    ----------
    n
        Pixels.
    exposure_s
        [s].
    photons
        Mean photons per pixel; None where the irradiance is unknown.
    mean, dark_mean
        [DN].
    variance, dark_variance
        Temporal [DN^2].
    mean_difference
        First frame less second [DN].
    spatial_variance
        Covariance of the high-passed frames, signed; NaN where the plane is too small [DN^2].
    top_fraction
        Of pixel values at the highest code.
    dark_measured
        Whether darks were taken at this exposure; else the dark signal was read off a line.

    """

    n: int
    exposure_s: Floats
    photons: Floats | None
    mean: Floats
    dark_mean: Floats
    variance: Floats
    dark_variance: Floats
    mean_difference: Floats
    spatial_variance: Floats
    top_fraction: Floats
    dark_measured: NDArray[np.bool_]

    @property
    def steps(self) -> int:
        """Return the number of steps."""
        return self.mean.size

    @property
    def signal(self) -> Floats:
        """Return the mean above the dark mean [DN]."""
        return self.mean - self.dark_mean

    @property
    def light_variance(self) -> Floats:
        """Return the temporal variance above that in the dark [DN^2]."""
        return self.variance - self.dark_variance

    @property
    def varies_time(self) -> bool:
        """Return whether every step has an exposure time of its own (method I)."""
        return np.unique(self.exposure_s).size == self.steps > 1

    @property
    def exposure(self) -> Floats | None:
        """Return the abscissa: photons, or the exposure time where it alone varies; None where neither is known."""
        if self.photons is not None:
            return self.photons
        return self.exposure_s if self.varies_time else None

    @property
    def light_variance_error(self) -> Floats:
        """Return the standard error of ``light_variance`` from the number of pixels, (19) [DN^2]."""
        return np.sqrt(2.0 / self.n * (self.variance**2 + self.dark_variance**2))

    @property
    def signal_error(self) -> Floats:
        """Return the standard error of ``signal`` from the noise of its pixels [DN]."""
        return np.sqrt((self.variance + self.dark_variance) / (2.0 * self.n))
