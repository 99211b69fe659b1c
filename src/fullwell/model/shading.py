"""Surfaces that lens shading is described by, as functions of place and parameters (METHOD 6.2).

Places are pixels of one CFA plane, from 0 at the centre of the first. Every surface says what it is worth and how it
changes with each parameter. Distances inside the formulas count in half diagonals of the plane, so that parameters of
small and large planes compare.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
Basis = Callable[[FloatArray], FloatArray]

RADIAL_POWERS: Final = 6
"""Even powers of the radius in the radial surface. Up to the tenth, a plain cosine-fourth lens would be missed by two
standard errors at the edges of a long exposure; up to the twelfth, by less than half of one."""


class Surface(Protocol):
    """A surface over a plane with parameters still open."""

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """What each parameter is."""
        ...

    def value(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the surface at places that broadcast against each other, in the unit of the amplitude."""
        ...

    def jacobian(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the derivatives by the P parameters at n places, shape (P, n)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Plane:
    """Rows and columns of a plane [pixel], and places in it counted in half diagonals from its middle."""

    rows: int
    columns: int

    @property
    def half_diagonal(self) -> float:
        """From the middle to the centre of a corner pixel, at least one half [pixel]."""
        return max(0.5 * math.hypot(self.rows - 1, self.columns - 1), 0.5)

    @property
    def middle(self) -> tuple[float, float]:
        """Row and column of the middle [pixel]."""
        return (self.rows - 1) / 2.0, (self.columns - 1) / 2.0

    def centred(self, row: ArrayLike, column: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return row and column from the middle [half diagonal]."""
        y, x = self.middle
        scale = 1.0 / self.half_diagonal
        return (np.asarray(row, np.float64) - y) * scale, (np.asarray(column, np.float64) - x) * scale


def legendre(position: FloatArray, size: int, degree: int) -> FloatArray:
    """Return the Legendre polynomials over an axis of ``size`` pixels, shape (n, degree + 1).

    Parameters
    ----------
    position
        Places along the axis, shape (n,) [pixel].
    size
        Pixels of the axis, which spans -1/2 to size - 1/2.
    degree
        The highest.

    """
    x = (2.0 * position + 1.0) / size - 1.0
    out = np.ones((degree + 1, x.size))
    out[1:2] = x
    for n in range(2, degree + 1):
        out[n] = (out[n - 1] * x * (2 * n - 1) - out[n - 2] * (n - 1)) / n
    return out.T


def cubic_splines(position: FloatArray, size: int, terms: int) -> FloatArray:
    """Return cubic B-splines on equal knots over an axis of ``size`` pixels, shape (n, terms); they add up to 1.

    Parameters
    ----------
    position
        Places along the axis, shape (n,) [pixel]; beyond its ends the last cubic goes on.
    size
        Pixels of the axis, which spans -1/2 to size - 1/2.
    terms
        How many, at least 4.

    Examples
    --------
    >>> cubic_splines(np.array([-0.5]), 10, 4).round(4).tolist()
    [[0.1667, 0.6667, 0.1667, 0.0]]

    """
    place = (position + 0.5) * ((terms - 3) / size)
    first = np.clip(np.floor(place), 0, terms - 4).astype(np.intp)
    t = place - first
    pieces = np.stack(
        [(1.0 - t) ** 3, 3.0 * t**3 - 6.0 * t**2 + 4.0, -3.0 * t**3 + 3.0 * t**2 + 3.0 * t + 1.0, t**3], axis=-1
    )
    out = np.zeros((position.size, terms))
    out[np.arange(position.size)[:, None], first[:, None] + np.arange(4)] = pieces / 6.0
    return out


@dataclass(frozen=True, slots=True, kw_only=True)
class TensorSurface:
    """A sum of products of one function of the row and one of the column.

    Parameters
    ----------
    row_basis, column_basis
        From n places along the axis to the values of R (C) functions there, shape (n, R).
    kept
        Which products take part, shape (R, C); the parameters are those, row by row.

    """

    row_basis: Basis
    column_basis: Basis
    kept: NDArray[np.bool_]

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The functions' numbers, row first."""
        return tuple(f"c{row},{column}" for row, column in np.argwhere(self.kept))

    def value(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the surface at places that broadcast against each other."""
        coefficients = np.zeros(self.kept.shape)
        coefficients[self.kept] = parameters
        y, x = np.asarray(row, np.float64), np.asarray(column, np.float64)
        if y.ndim == 2 and x.ndim == 2 and y.shape[1] == 1 and x.shape[0] == 1:
            return self.row_basis(y[:, 0]) @ coefficients @ self.column_basis(x[0]).T
        y, x = np.broadcast_arrays(y, x)
        along = self.row_basis(y.ravel()) @ coefficients
        return np.sum(along * self.column_basis(x.ravel()), axis=-1).reshape(y.shape)

    def jacobian(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:  # noqa: ARG002 - linear
        """Return the products at n places, shape (P, n)."""
        y, x = np.broadcast_arrays(np.asarray(row, np.float64), np.asarray(column, np.float64))
        rows, columns = np.nonzero(self.kept)
        return np.ascontiguousarray((self.row_basis(y.ravel())[:, rows] * self.column_basis(x.ravel())[:, columns]).T)


def polynomial_surface(plane: Plane, degree: int) -> TensorSurface:
    """Return the polynomial of total degree ``degree`` in row and column: 6 terms for 2, 15 for 4."""
    order = np.arange(degree + 1)
    return TensorSurface(
        row_basis=lambda row: legendre(row, plane.rows, degree),
        column_basis=lambda column: legendre(column, plane.columns, degree),
        kept=order[:, None] + order <= degree,
    )


def spline_surface(plane: Plane, terms: tuple[int, int]) -> TensorSurface:
    """Return the tensor product of cubic splines with so many terms along rows and along columns."""
    return TensorSurface(
        row_basis=lambda row: cubic_splines(row, plane.rows, terms[0]),
        column_basis=lambda column: cubic_splines(column, plane.columns, terms[1]),
        kept=np.ones(terms, dtype=np.bool_),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CosineSurface:
    """The cosine-fourth law about a free centre with a free focal length, S = A q^-2 with a quadratic q.

    q = 1 + a y + b x + u (y^2 + x^2) is (1 + r^2/f^2) about its own centre (-a, -b)/2u but for a factor, and stays
    smooth where nothing shades, where centre and focal length mean nothing. y, x in half diagonals from the middle of
    the plane.
    """

    plane: Plane

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """A in the signal's unit, a, b and u per half diagonal (squared)."""
        return ("amplitude", "row_slope", "column_slope", "curvature")

    def quadratic(self, row: ArrayLike, column: ArrayLike, slopes: FloatArray) -> FloatArray:
        """Return q for (a, b, u) [1]; places broadcast."""
        y, x = self.plane.centred(row, column)
        return 1.0 + (slopes[0] + slopes[2] * y) * y + (slopes[1] + slopes[2] * x) * x

    def value(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the surface at places that broadcast against each other."""
        return parameters[0] * self.quadratic(row, column, parameters[1:]) ** -2.0

    def functions(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return what the amplitude multiplies at n places, shape (1, n)."""
        return np.ravel(self.quadratic(row, column, parameters[1:]) ** -2.0)[None]

    def jacobian(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the derivatives at n places, shape (4, n)."""
        y, x = (np.ravel(part) for part in np.broadcast_arrays(*self.plane.centred(row, column)))
        q = 1.0 + (parameters[1] + parameters[3] * y) * y + (parameters[2] + parameters[3] * x) * x
        share = q**-2.0
        bend = -2.0 * parameters[0] * share / q
        return np.stack([share, bend * y, bend * x, bend * (y * y + x * x)])

    def axis(self, parameters: FloatArray) -> tuple[float, float, float] | None:
        """Return row and column of the centre and the focal length [pixel]; None where nothing shades."""
        _, a, b, u = (float(one) for one in parameters)
        if u <= 0.0 or (level := 1.0 - (a * a + b * b) / (4.0 * u)) <= 0.0:
            return None
        scale = self.plane.half_diagonal
        row, column = self.plane.middle
        return row - scale * a / (2.0 * u), column - scale * b / (2.0 * u), scale * math.sqrt(level / u)


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedCosineSurface:
    """The cosine-fourth law about the middle of the plane with a known focal length [pixel]: an amplitude alone."""

    plane: Plane
    focal_length_pixels: float

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The amplitude, in the signal's unit."""
        return ("amplitude",)

    def value(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the surface at places that broadcast against each other."""
        reach = self.focal_length_pixels / self.plane.half_diagonal
        y, x = self.plane.centred(row, column)
        return parameters[0] * (1.0 + (y * y + x * x) / reach**2) ** -2.0

    def jacobian(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the derivative at n places, shape (1, n)."""
        return np.ravel(self.value(row, column, np.ones_like(parameters)))[None]


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialSurface:
    """Even powers of the distance from a free centre times a tilted plane.

    S = (1 + s y + t x) (a0 + a1 r^2 + ... + a6 r^12); y, x and r in half diagonals, y and x from the middle of the
    plane, r from the centre. Parameters: a0...a6, s, t, row and column of the centre [pixel].

    Parameters
    ----------
    plane
        Size of the plane.
    powers
        Even powers of r above 0.

    """

    plane: Plane
    powers: int = RADIAL_POWERS

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """a0 to a6 in the signal's unit, tilts per half diagonal, centre in pixels."""
        powers = tuple(f"r{2 * power}" for power in range(self.powers + 1))
        return (*powers, "row_tilt", "column_tilt", "centre_row", "centre_column")

    def value(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the surface at places that broadcast against each other."""
        y, x = self.plane.centred(row, column)
        v, h = self.plane.centred(parameters[-2], parameters[-1])
        rho = (y - v) ** 2 + (x - h) ** 2
        tilted = 1.0 + parameters[-4] * y + parameters[-3] * x
        return tilted * np.asarray(np.polynomial.polynomial.polyval(rho, parameters[:-4]), np.float64)

    def functions(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return what a0 to a6 multiply at n places, shape (7, n)."""
        y, x = (np.ravel(part) for part in np.broadcast_arrays(*self.plane.centred(row, column)))
        v, h = self.plane.centred(parameters[-2], parameters[-1])
        out = np.empty((self.powers + 1, y.size))
        _powers(1.0 + parameters[-4] * y + parameters[-3] * x, (y - v) ** 2 + (x - h) ** 2, out)
        return out

    def jacobian(self, row: ArrayLike, column: ArrayLike, parameters: FloatArray) -> FloatArray:
        """Return the derivatives at n places, shape (11, n)."""
        y, x = (np.ravel(part) for part in np.broadcast_arrays(*self.plane.centred(row, column)))
        v, h = self.plane.centred(parameters[-2], parameters[-1])
        dy, dx = y - v, x - h
        rho = dy * dy + dx * dx
        out = np.empty((self.powers + 5, y.size))
        tilted = 1.0 + parameters[-4] * y + parameters[-3] * x
        _powers(tilted, rho, out[: self.powers + 1])
        value, slope = _with_slope(parameters[:-4], rho)
        np.multiply(value, y, out=out[-4])
        np.multiply(value, x, out=out[-3])
        slope *= tilted * (-2.0 / self.plane.half_diagonal)
        np.multiply(slope, dy, out=out[-2])
        np.multiply(slope, dx, out=out[-1])
        return out


def _powers(first: FloatArray, factor: FloatArray, out: FloatArray) -> None:
    """Fill the rows of ``out`` with first * factor^0, first * factor^1 and so on."""
    out[0] = first
    for power in range(len(out) - 1):
        np.multiply(out[power], factor, out=out[power + 1])


def _with_slope(coefficients: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a polynomial and its derivative, by Horner's rule."""
    value, slope = np.full_like(at, coefficients[-1]), np.zeros_like(at)
    for coefficient in coefficients[-2::-1]:
        slope *= at
        slope += value
        value *= at
        value += coefficient
    return value, slope
