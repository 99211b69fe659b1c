"""Boxes on the sheet, and how values become places in them: points from the left and from the top."""

import math
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

_FAR: Final = 1e4
"""Places are not farther from a box than this: renderers reckon in few digits."""
_TINY: Final = 1e-300


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A rectangle on the sheet.

    Parameters
    ----------
    left, top, width, height
        From the left and upper edge of the sheet [point].

    """

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Return the right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Return the lower edge."""
        return self.top + self.height

    def inside(self, *, left: float = 0.0, top: float = 0.0, right: float = 0.0, bottom: float = 0.0) -> "Box":
        """Return what is left within margins."""
        return Box(
            left=self.left + left,
            top=self.top + top,
            width=max(self.width - left - right, 1.0),
            height=max(self.height - top - bottom, 1.0),
        )

    def widened(self, by: float) -> "Box":
        """Return the box with a margin around it."""
        return self.inside(left=-by, top=-by, right=-by, bottom=-by)

    def shaped(self, ratio: float, *, anchor: float = 0.5) -> "Box":
        """Return the largest box of a width over height inside; ``anchor`` 0 puts it to the top, 1 to the bottom."""
        width, height = min(self.width, self.height * ratio), min(self.height, self.width / ratio)
        return replace(
            self,
            left=self.left + (self.width - width) / 2.0,
            top=self.top + anchor * (self.height - height),
            width=width,
            height=height,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scale:
    """An axis from its low to its high end, which may be the lower number; linear or logarithmic."""

    low: float
    high: float
    log: bool = False

    def share(self, values: Array) -> Array:
        """Return where values stand between the ends, 0 to 1; on a logarithmic axis zero is far below."""
        if self.log:
            low, high = math.log(self.low), math.log(self.high)
            return (np.log(np.where(values > 0.0, values, np.where(np.isnan(values), np.nan, _TINY))) - low) / (
                high - low
            )
        return (values - self.low) / (self.high - self.low)


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """The box of a panel with its two scales."""

    box: Box
    x: Scale
    y: Scale

    def across(self, values: Array) -> Array:
        """Return places from the left edge of the sheet."""
        return self.box.left + _near(self.x.share(values) * self.box.width)

    def down(self, values: Array) -> Array:
        """Return places from the upper edge of the sheet."""
        return self.box.bottom - _near(self.y.share(values) * self.box.height)

    def slope(self, slope: float) -> float:
        """Return the angle of a line that rises by ``slope``, in units of the scales, per unit across [degree].

        A unit of a logarithmic scale is a decade.
        """
        across, up = (
            abs(math.log10(one.high / one.low)) if one.log else abs(one.high - one.low) for one in (self.x, self.y)
        )
        return math.degrees(math.atan2(slope * self.box.height / up, self.box.width / across))


def _near(places: Array) -> Array:
    return np.where(np.isfinite(places), np.clip(places, -_FAR, _FAR), np.nan)
