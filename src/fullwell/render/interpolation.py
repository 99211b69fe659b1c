"""Smooth surfaces known on a coarse grid, evaluated anywhere: separable cubic splines."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def interpolated(
    values: FloatArray, *, rows: FloatArray, columns: FloatArray, at: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Return a gridded surface at the outer product of rows and columns.

    The interpolating cubic spline of each axis (not-a-knot ends; a lower degree where there are fewer than four
    points) is linear in the values, so two small matrices do all the work. Beyond the grid the outermost polynomial
    goes on: meant for fractions of a step.

    Parameters
    ----------
    values
        Shape (V, H), any unit.
    rows, columns
        Where they stand, ascending, shapes (V,) and (H,).
    at
        Rows (R,) and columns (C,) that are asked for, in the same coordinates.

    Returns
    -------
    ndarray
        Shape (R, C), the unit of ``values``.

    Examples
    --------
    >>> axis = np.arange(5.0)
    >>> surface = axis[:, None] ** 3 + axis
    >>> interpolated(surface, rows=axis, columns=axis, at=(np.array([1.5]), np.array([2.25]))).round(12)
    array([[5.625]])

    """
    at_rows, at_columns = at
    return _weights(rows, at_rows) @ values @ _weights(columns, at_columns).T


def _weights(places: FloatArray, at: FloatArray) -> FloatArray:
    """Return the matrix that takes values at ``places`` to values at ``at``, shape (at, places)."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 - loads when used

    if places.size == 1:
        return np.ones((at.size, 1))
    spline = make_interp_spline(places, np.eye(places.size), k=_degree(places.size))
    return np.asarray(spline(at), dtype=np.float64)


def _degree(points: int) -> int:
    """Return the degree of the spline: cubic where there are points enough, else what fits."""
    return 3 if points >= 4 else min(points - 1, 2)
