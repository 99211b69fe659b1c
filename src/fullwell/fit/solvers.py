"""The two iterative solvers of SciPy that the fits need, with types of their own."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function that changes sign between two points is zero (Brent)."""
    from scipy.optimize import brentq  # noqa: PLC0415 - loads when used

    solve = cast("Callable[..., float]", brentq)
    return float(solve(function, low, high, xtol=1e-14))


def levenberg_marquardt(
    residuals: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    jacobian: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    start: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Minimize a sum of squares.

    Returns
    -------
    tuple
        The parameters, the inverse of J' J there, and the sum of squares.

    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - loads when used

    solve = cast("Callable[..., Any]", least_squares)
    solution = solve(residuals, start, jac=jacobian, method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    parameters = np.asarray(solution.x, np.float64)
    slope = jacobian(parameters)
    return parameters, np.asarray(np.linalg.pinv(slope.T @ slope), np.float64), 2.0 * float(solution.cost)
