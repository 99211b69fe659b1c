"""The Pixel study's lens-shading map: one quadratic surface per plane, fitted to every pixel alike (METHOD 5.3).

As published the pedestal is left in and no pixel weighs more than another; what that does to the corners is told in
METHOD 5.3. Coordinates are the study's: x counts rows and y counts columns of the plane, both from 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.row_products import row_products
from fullwell.raw.cfa import cell
from fullwell.statistics.pixels import PixelSums


@dataclass(frozen=True, slots=True, kw_only=True)
class Poly22:
    """The surface p00 + p10 x + p01 y + p20 x^2 + p11 x y + p02 y^2 over one plane.

    Parameters
    ----------
    p00, p10, p01, p20, p11, p02
        Coefficients for x = row and y = column, counted from 1 [DN].
    rows, columns
        Size of the plane [pixel].
    maximum
        Highest value on the plane's own grid of pixels [DN].

    """

    p00: float
    p10: float
    p01: float
    p20: float
    p11: float
    p02: float
    rows: int
    columns: int
    maximum: float

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Return p00, p10, p01, p20, p11, p02."""
        return (self.p00, self.p10, self.p01, self.p20, self.p11, self.p02)


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyMap:
    """The stacked map of the whole mosaic: each plane's surface over its maximum.

    Parameters
    ----------
    surfaces
        One per CFA site, row-major.
    height, width
        Size of the mosaic [pixel].

    """

    surfaces: tuple[Poly22, ...]
    height: int
    width: int

    @property
    def cell(self) -> int:
        """Return the period of the pattern in pixels."""
        return 1 if len(self.surfaces) == 1 else 2

    def region(self, *, top: int, left: int, height: int, width: int) -> NDArray[np.float64]:
        """Return the map over a region of the mosaic.

        Parameters
        ----------
        top, left
            First row and column, counted from 0 [pixel].
        height, width
            Size [pixel].

        Returns
        -------
        ndarray
            Shape (height, width), at most 1 [1].

        """
        period = self.cell
        values = np.empty((height, width))
        for site, surface in enumerate(self.surfaces):
            row, column = (site // period - top) % period, (site % period - left) % period
            x = _counted((top + row) // period, -(-(height - row) // period))
            y = _counted((left + column) // period, -(-(width - column) // period))
            values[row::period, column::period] = evaluate(surface.coefficients, x, y) / surface.maximum
        return values


def fit_poly22(sums: PixelSums, frames: int, *, black_dn: float = 0.0) -> Poly22:
    """Fit a quadratic surface to the burst mean of one plane, every pixel alike.

    Parameters
    ----------
    sums
        Sum over the frames of each pixel, shape (rows, columns), at least 3 x 3 [DN].
    frames
        Frames in the sum.
    black_dn
        Subtracted from the mean first; as published nothing is [DN].

    Returns
    -------
    Poly22
        Least squares on the complete grid. Products of orthogonal polynomials in the row and in the column make the
        normal equations diagonal, so the solution is exact to rounding.

    Raises
    ------
    ValueError
        Where the plane is too small for six terms.

    """
    rows, columns = sums.shape
    if min(rows, columns) < 3:
        raise ValueError(f"a quadratic surface needs a plane of 3 x 3 pixels or more, not {rows} x {columns}")
    along_x, along_y = _orthogonal(rows), _orthogonal(columns)
    plane = sums.view()
    plane.flags.writeable = False
    products = along_x @ np.stack(row_products(plane, along_y[1], along_y[2]), axis=1) / frames
    products[0, 0] -= black_dn * sums.size
    norms = np.outer(np.square(along_x).sum(axis=1), np.square(along_y).sum(axis=1))
    coefficients = _from_one(products / norms, rows, columns)
    p00, p10, p01, p20, p11, p02 = coefficients
    return Poly22(
        p00=p00,
        p10=p10,
        p01=p01,
        p20=p20,
        p11=p11,
        p02=p02,
        rows=rows,
        columns=columns,
        maximum=_highest(coefficients, rows, columns),
    )


def fit_legacy_map(sums: PixelSums, frames: int, *, cfa: str, black_dn: Sequence[float] | None = None) -> LegacyMap:
    """Fit the map of a burst of flats.

    Parameters
    ----------
    sums
        Sum over the frames of each pixel, shape (height, width) [DN].
    frames
        Frames in the sum.
    cfa
        Order at the top-left pixel, or ``mono``.
    black_dn
        Black level of each CFA site, row-major, for the variant that subtracts it; None leaves the pedestal in, as
        published [DN].

    """
    period = cell(cfa)
    height, width = sums.shape
    surfaces = tuple(
        fit_poly22(
            sums[site // period :: period, site % period :: period],
            frames,
            black_dn=0.0 if black_dn is None else black_dn[site],
        )
        for site in range(period**2)
    )
    return LegacyMap(surfaces=surfaces, height=height, width=width)


def evaluate(coefficients: Sequence[float], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the surface on a grid.

    Parameters
    ----------
    coefficients
        p00, p10, p01, p20, p11, p02.
    x, y
        Rows and columns of the plane, counted from 1, shapes (V,) and (H,).

    Returns
    -------
    ndarray
        Shape (V, H), in the unit of the coefficients.

    """
    p00, p10, p01, p20, p11, p02 = coefficients
    across = (p01 + p11 * x)[:, None] * y
    across += (p00 + x * (p10 + p20 * x))[:, None]
    across += p02 * y**2
    return across


def _counted(first: int, count: int) -> NDArray[np.float64]:
    """Return the pixel coordinates from index ``first`` on, counted from 1 as in the study."""
    return np.arange(first + 1, first + count + 1, dtype=np.float64)


def _orthogonal(size: int) -> NDArray[np.float64]:
    """Return 1, u and u^2 less its mean on the centred grid: orthogonal, shape (3, size)."""
    centred = np.arange(size, dtype=np.float64) - (size - 1) / 2.0
    return np.stack([np.ones(size), centred, centred**2 - (size**2 - 1) / 12.0])


def _from_one(centred: NDArray[np.float64], rows: int, columns: int) -> tuple[float, ...]:
    """Return p00 ... p02 from coefficients of the centred polynomials, row power first."""
    x, y = (rows + 1) / 2.0, (columns + 1) / 2.0
    c00, c01, c02 = (float(value) for value in centred[0])
    c10, c11, c20 = float(centred[1, 0]), float(centred[1, 1]), float(centred[2, 0])
    mean_square_x, mean_square_y = (rows**2 - 1) / 12.0, (columns**2 - 1) / 12.0
    p00 = c00 - c10 * x - c01 * y + c11 * x * y + c20 * (x**2 - mean_square_x) + c02 * (y**2 - mean_square_y)
    return (p00, c10 - 2.0 * x * c20 - y * c11, c01 - 2.0 * y * c02 - x * c11, c20, c11, c02)


def _highest(coefficients: Sequence[float], rows: int, columns: int) -> float:
    """Return the highest value on the grid: in every row it is at an end, or beside the top of the row's parabola."""
    p00, p10, p01, p20, p11, p02 = coefficients
    x = _counted(0, rows)[:, None]
    slope = p01 + p11 * x
    top = np.floor(slope / (-2.0 * p02)) if p02 < 0.0 else np.zeros_like(x)
    y = np.clip(np.hstack([np.zeros_like(x), top, top + 1.0, np.full_like(x, columns)]), 1.0, columns)
    return float(np.max(slope * y + (p00 + x * (p10 + p20 * x)) + p02 * y**2))
