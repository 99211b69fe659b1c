"""Sums over a grid that a least-squares fit of the cosine-fourth law asks for, in one pass.

Of S = A q^-2 with q = 1 + a y + b x + u (y^2 + x^2) the derivatives by A, a, b and u are q^-2 and -2 A q^-3 times y, x
and y^2 + x^2; the loop takes q^-3 without its factor.
It is compiled into the function that calls it for the reason `pattern_tiles` gives.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@njit(cache=True, nogil=True, forceinline=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _add_row(
    y: float, x: FloatArray, signal: FloatArray, weight: FloatArray, law: tuple[float, float, float, float]
) -> tuple[float, ...]:
    """Return the sums over one row."""
    amplitude, a, b, u = law
    along = 1.0 + (a + u * y) * y
    chi = g0 = g1 = g2 = g3 = 0.0
    s00 = s01 = s02 = s03 = s11 = s12 = s13 = s22 = s23 = s33 = 0.0
    for k in range(x.size):
        inverse = 1.0 / (along + (b + u * x[k]) * x[k])
        f0 = inverse * inverse
        cube = f0 * inverse
        f1, f2, f3 = cube * y, cube * x[k], cube * (y * y + x[k] * x[k])
        residual = signal[k] - amplitude * f0
        w = weight[k]
        w0, w1, w2 = w * f0, w * f1, w * f2
        wr = w * residual
        chi += wr * residual
        g0 += wr * f0
        g1 += wr * f1
        g2 += wr * f2
        g3 += wr * f3
        s00 += w0 * f0
        s01 += w0 * f1
        s02 += w0 * f2
        s03 += w0 * f3
        s11 += w1 * f1
        s12 += w1 * f2
        s13 += w1 * f3
        s22 += w2 * f2
        s23 += w2 * f3
        s33 += w * f3 * f3
    return (chi, g0, g1, g2, g3, s00, s01, s02, s03, s11, s12, s13, s22, s23, s33)


@njit(cache=True, nogil=True, error_model="numpy")
def cosine_sums(
    y: FloatArray, x: FloatArray, signal: FloatArray, weight: FloatArray, law: tuple[float, float, float, float]
) -> FloatArray:
    """Return chi-square, the gradient and the information about a cosine-fourth law.

    Parameters
    ----------
    y, x
        Places of the rows and columns of the grid, shapes (V,) and (H,).
    signal, weight
        Shape (V, H); where the weight is 0 the signal must be finite.
    law
        A, a, b and u.

    Returns
    -------
    ndarray
        Chi-square r' W r of the residuals r; F W r, F being q^-2 and q^-3 times y, x and y^2 + x^2; and the upper
        triangle of F W F', row by row: shape (15,).

    """
    total = np.zeros(15)
    for r in range(y.size):
        row = _add_row(y[r], x, signal[r], weight[r], law)
        for k in range(15):
            total[k] += row[k]
    return total
