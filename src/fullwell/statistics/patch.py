"""Mean and variance of one patch of one CFA plane, its uneven light removed (METHOD 1.1)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class PatchStatistics:
    """What a patch says.

    Parameters
    ----------
    n
        Pixels.
    dof
        n less the terms of the surface.
    mean
        Of the patch [unit of the values].
    variance
        Sum of squares about the surface over ``dof`` [unit of the values squared]; NaN without degrees of freedom.

    """

    n: int
    dof: int
    mean: float
    variance: float


def patch_statistics(
    values: NDArray[np.uint16 | np.float32 | np.float64], *, terms: Literal[1, 3, 6] = 6
) -> PatchStatistics:
    """Return mean and variance of a patch about a polynomial surface.

    Parameters
    ----------
    values
        One plane's pixels, shape (rows, columns) [DN].
    terms
        1: nothing but the mean is removed; 3: a plane; 6: a quadratic surface.

    """
    raise NotImplementedError
