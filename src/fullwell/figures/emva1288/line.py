"""Unweighted straight lines with the standard deviations of their coefficients, as the standard reports them."""

from dataclasses import dataclass

import numpy as np

from fullwell.figures.emva1288.sweep import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """Least squares with a free offset.

    Parameters
    ----------
    slope, offset
        In the units of the data.
    slope_error, offset_error
        One standard deviation from the residuals; None for two points.
    points
        How many.

    """

    slope: float
    offset: float
    slope_error: float | None
    offset_error: float | None
    points: int

    @property
    def dof(self) -> int:
        """Return the degrees of freedom of the residuals."""
        return self.points - 2

    def at(self, x: Floats) -> Floats:
        """Return the line's values."""
        return self.offset + self.slope * x


def fit_line(x: Floats, y: Floats) -> Line:
    """Fit a line.

    Examples
    --------
    >>> line = fit_line(np.array([100.0, 200, 300, 400]), np.array([41.0, 80, 119, 162]))
    >>> round(line.slope, 9), round(line.slope_error, 9), round(line.offset_error, 9)
    (0.402, 0.006928203, 1.897366596)

    """
    centre, level = float(x.mean()), float(y.mean())
    spread = float(np.sum((x - centre) ** 2))
    slope = float(np.sum((x - centre) * (y - level))) / spread
    offset = level - slope * centre
    points = x.size
    if points < 3:
        return Line(slope=slope, offset=offset, slope_error=None, offset_error=None, points=points)
    variance = float(np.sum((y - offset - slope * x) ** 2)) / (points - 2)
    return Line(
        slope=slope,
        offset=offset,
        slope_error=float(np.sqrt(variance / spread)),
        offset_error=float(np.sqrt(variance * (1.0 / points + centre**2 / spread))),
        points=points,
    )


def slope_error_from(x: Floats, y_errors: Floats) -> float:
    """Return the standard error of an unweighted slope from the known errors of its points."""
    centred = x - x.mean()
    return float(np.sqrt(np.sum(centred**2 * y_errors**2)) / np.sum(centred**2))


def offset_error_from(x: Floats, y_errors: Floats) -> float:
    """Return the standard error of the offset of an unweighted line from the known errors of its points."""
    centre = x.mean()
    shares = 1.0 / x.size - centre * (x - centre) / np.sum((x - centre) ** 2)
    return float(np.sqrt(np.sum((shares * y_errors) ** 2)))


def slope_through_origin(x: Floats, y: Floats) -> float:
    """Return the unweighted slope of a line through the origin, (49)."""
    return float(np.sum(x * y) / np.sum(x * x))
