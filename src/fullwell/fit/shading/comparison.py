"""Do two bursts show the same shading? A difference over its standard error, not by eye (METHOD 6.5)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.shading.data import ShadingData


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingDifference:
    """The smooth part of b/a - 1 after a common scale is removed.

    Parameters
    ----------
    rows, columns
        Where the maps are evaluated, shapes (V,) and (H,) [pixel of the plane].
    difference
        Relative difference of shape, shape (V, H), its weighted mean 0 [1].
    std_error
        Of ``difference``, of the same shape [1].
    chi_square, dof, p_value
        Test of no difference: of all spline coefficients but the scale, with their covariance.
    largest
        Largest absolute difference over its standard error [1].
    rms
        Root mean square of ``difference`` [1].
    scale
        b over a, all bins together [1].
    misfit
        Whether bins scatter about the smooth difference by more than temporal noise (beyond 99 %); errors are then
        scaled by that scatter.

    """

    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    difference: NDArray[np.float64]
    std_error: NDArray[np.float64]
    chi_square: float
    dof: int
    p_value: float
    largest: float
    rms: float
    scale: float
    misfit: bool


def compare_shading(
    a: ShadingData, b: ShadingData, *, same_sensor: bool = True, shape: tuple[int, int] = (48, 64)
) -> ShadingDifference:
    """Return how the shading of b differs from that of a (METHOD 6.5).

    Parameters
    ----------
    a, b
        The same bins of two bursts, black subtracted; bins that either leaves out are left out.
    same_sensor
        PRNU is then common to both and drops out, errors are temporal; else it counts in both.
    shape
        Rows and columns of the maps; fewer where the plane has fewer bins.

    Raises
    ------
    ValueError
        Where the bins are not the same, or too few are left.

    """
    raise NotImplementedError
