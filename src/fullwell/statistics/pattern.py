"""Fixed pattern of a map: what is left of each tile when its quadratic surface is taken away (METHOD 5.1, 5.5).

A map is the mean of a burst less that of the dark one, or a slope or an intercept per pixel. Lens shading is gone with
the surface; what is left is laid out in rows and columns, so that row, column and pixel pattern can be told apart.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """Variance of one plane of a map about the quadratic surfaces of its tiles, and where it lies.

    With ``relative`` maps every residual is divided by its surface: map / surface - 1.

    Parameters
    ----------
    size
        Edge of a tile [pixel of the plane]; the last row and column of tiles may be smaller.
    n
        Pixels of each tile, shape (tile rows, tile columns).
    dof
        n - 6, of the same shape; 0 where a tile does not count: smaller than 8 pixels on a side, not chosen, holding a
        value that is not finite, or, where relative, with a surface that is not positive everywhere.
    mean
        Mean of the map over each tile [unit of the map].
    variance
        Sum of squared residuals over ``dof`` [unit of the map squared; 1 if relative]; NaN where the tile does not
        count.
    inverse_square
        Mean over the tile of surface^-2, which turns the variance of noise of the map into that of the residuals
        [unit of the map^-2]; 1 if not relative; NaN where the tile does not count.
    row_mean_square, column_mean_square, pixel_mean_square
        Mean squares of the two-way layout of the residuals [as ``variance`` ]. A row is summed over all tiles that
        count in a row of tiles, a column alike; pixels are what is left inside tiles. Their expectations are
        ``columns`` s_row^2 + s_pixel^2, ``rows`` s_column^2 + s_pixel^2, s_pixel^2. NaN without degrees of freedom.
    row_dof, column_dof, pixel_dof
        Their degrees of freedom: sum over rows of tiles of (height - 3), over columns of tiles of (width - 3), and
        over tiles of (n - height - width).
    rows, columns
        Pixels that a column and a row are summed over, on average by degrees of freedom.

    """

    size: int
    n: NDArray[np.int64]
    dof: NDArray[np.int64]
    mean: NDArray[np.float64]
    variance: NDArray[np.float64]
    inverse_square: NDArray[np.float64]
    row_mean_square: float
    column_mean_square: float
    pixel_mean_square: float
    row_dof: int
    column_dof: int
    pixel_dof: int
    rows: float
    columns: float


def pattern(
    plane: NDArray[np.float32 | np.float64], *, tile: int, relative: bool, use: NDArray[np.bool_] | None = None
) -> Pattern:
    """Return the fixed pattern of one plane of a map.

    Parameters
    ----------
    plane
        Shape (rows, columns), of any strides [any unit].
    tile
        Edge of a tile, at least 8 [pixel].
    relative
        Whether residuals are divided by their surface.
    use
        Which tiles count, shape (tile rows, tile columns); None: all.

    """
    raise NotImplementedError
