"""The Pixel study's DSNU: the spread of shading-corrected flats against exposure (METHOD 5.3)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.pixels import line_coefficients

_CONTAINER: Final = 65535.0
"""What im2double divides 16-bit codes by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StdLine:
    """polyfit of the spatial standard deviation of shading-corrected frames against exposure: the study's DSNU.

    Parameters
    ----------
    exposure_s, std_dn
        One per frame, shape (n,) [s], [DN].
    slope_dn_per_s, intercept_dn
        The line [DN/s], [DN].

    """

    exposure_s: NDArray[np.float64]
    std_dn: NDArray[np.float64]
    slope_dn_per_s: float
    intercept_dn: float

    @property
    def as_published(self) -> float:
        """Return the intercept of frames that im2double had divided by 65535, which was then taken for DN."""
        return self.intercept_dn / _CONTAINER


def fit_std_line(exposure_s: Sequence[float], std_dn: Sequence[float]) -> StdLine:
    """Fit the spatial standard deviation of corrected frames against exposure (METHOD 5.3).

    Parameters
    ----------
    exposure_s, std_dn
        One per frame [s], [DN].

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    time, std = np.asarray(exposure_s, np.float64), np.asarray(std_dn, np.float64)
    slope, intercept = (float(value) for value in line_coefficients(exposure_s) @ std)
    return StdLine(exposure_s=time, std_dn=std, slope_dn_per_s=slope, intercept_dn=intercept)
