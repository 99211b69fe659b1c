"""The few small arrays a report shows as pictures; everything else it draws from rows and curves."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class RegionHistogram:
    """How the values of one rectangle of a difference image are distributed.

    Parameters
    ----------
    name
        What people call the rectangle.
    x, y, width, height
        Where it lies, in pixels of the picture's own array.
    codes
        Differences, ascending, shape (codes,) [DN].
    counts
        How often each occurs, shape (codes,).
    std_dn
        Standard deviation of the differences in the rectangle [DN].

    """

    name: str
    x: int
    y: int
    width: int
    height: int
    codes: NDArray[np.float64] | NDArray[np.int64]
    counts: NDArray[np.int64]
    std_dn: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferencePicture:
    """The difference of two frames of one series.

    Parameters
    ----------
    iso
        None where unknown.
    frames
        Names of the two frames.
    image
        First minus second, cropped or binned to at most 768 columns [DN].
    regions
        Rectangles whose histograms are drawn beside it, at most four.

    """

    iso: float | None
    frames: tuple[str, str]
    image: NDArray[np.float32] | NDArray[np.int16]
    regions: tuple[RegionHistogram, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class DarkZoom:
    """A small piece of a dark frame, or of the mean of several, magnified.

    Parameters
    ----------
    iso
        None where unknown.
    image
        Values above black, or above their own mean [DN].
    title
        What is seen; it goes into the caption.

    """

    iso: float | None
    image: NDArray[np.float32] | NDArray[np.int16]
    title: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Pictures:
    """All pictures of a report."""

    differences: tuple[DifferencePicture, ...] = ()
    dark_zooms: tuple[DarkZoom, ...] = ()
