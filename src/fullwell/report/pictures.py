"""The few small arrays a report shows as pictures; everything else it draws from rows and curves."""

from dataclasses import dataclass
from typing import Literal

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
class ShadingPicture:
    """The shading of one CFA plane in one burst of flats, on at most 64 x 64 points.

    Parameters
    ----------
    iso
        None where unknown.
    exposure_s
        Exposure of the burst [s].
    channel
        The plane.
    model
        Name of the model behind `fitted`: the one that was chosen.
    rows, columns
        Positions of the points in the plane, shapes (V,) and (H,) [plane pixel].
    measured
        Mean signal above black, NaN where bins were left out, shape (V, H) [DN].
    fitted
        The model's surface, shape (V, H) [DN].
    normalized
        The fitted surface over its value at the model's centre, shape (V, H) [1].
    residual
        measured / fitted - 1, shape (V, H) [1].
    cos4
        Cosine-fourth of the stated focal length, 1 at its centre, shape (V, H) [1];
        None where no focal length is known.
    legacy
        The study's own poly22 map, divided by its maximum, shape (V, H) [1]; None without.

    """

    iso: float | None
    exposure_s: float
    channel: str
    model: str
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    measured: NDArray[np.float64]
    fitted: NDArray[np.float64]
    normalized: NDArray[np.float64]
    residual: NDArray[np.float64]
    cos4: NDArray[np.float64] | None = None
    legacy: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingDifferencePicture:
    """How the shading of one burst of flats differs from that of the base burst.

    Parameters
    ----------
    iso, base_iso
        ISO of the two bursts; None where unknown.
    exposure_s, base_exposure_s
        Their exposures [s].
    difference
        Relative difference of the two maps, mean over the CFA planes, shape (V, H) [1].
    over_error
        The difference over its standard error, shape (V, H) [1].
    p_value
        Probability of so large a chi-square if the two maps were the same [1].

    """

    iso: float | None
    exposure_s: float
    base_iso: float | None
    base_exposure_s: float
    difference: NDArray[np.float64]
    over_error: NDArray[np.float64]
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponsePicture:
    """The slope of every pixel over exposure, for one crop or tile of the mosaic.

    Parameters
    ----------
    iso
        None where unknown.
    channel
        A plane, or `all` for the mosaic.
    title
        What is seen; it goes into the caption.
    image
        The slopes, binned to at most 128 x 128, shape (V, H) [unit].
    unit
        Unit of the slopes.
    kind
        `crop` (about a million pixels) or `tile` (64 x 64 pixels of the mosaic).

    """

    iso: float | None
    channel: str
    title: str
    image: NDArray[np.float64] | NDArray[np.float32]
    unit: str
    kind: Literal["crop", "tile"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartPicture:
    """A shot of a chart, with its patches.

    Parameters
    ----------
    iso
        None where unknown.
    title
        What is seen, for example the name of the file; it goes into the caption.
    image
        Tone-mapped preview, at most 1200 pixels wide, shape (V, H, 3).
    patches
        Name, left edge, top edge, width and height of each patch, in pixels of the preview.
    confidence
        Of the location of the patches, 0 to 1; None where they were given.
    corners
        x, y of the chart's corners in pixels of the preview, in order around it; empty where unknown.
    left_out
        Names of patches that took no part, because a rail clips them in every channel.

    """

    iso: float | None
    title: str
    image: NDArray[np.uint8]
    patches: tuple[tuple[str, float, float, float, float], ...]
    confidence: float | None = None
    corners: tuple[tuple[float, float], ...] = ()
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class RenderedPoints:
    """The patches of a chart as they came out in a developed picture of the same scene: a JPEG or PNG.

    Parameters
    ----------
    iso
        None where unknown.
    file
        Name of the picture.
    channels
        Its channels: ``R``, ``G``, ``B``, or ``mono``.
    mean, noise
        Mean and standard deviation of each patch over the largest value of the picture, shape (channels, patches) [1];
        NaN where a patch has none.

    """

    iso: float | None
    file: str
    channels: tuple[str, ...]
    mean: NDArray[np.float64]
    noise: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pictures:
    """All pictures of a report."""

    differences: tuple[DifferencePicture, ...] = ()
    dark_zooms: tuple[DarkZoom, ...] = ()
    shading: tuple[ShadingPicture, ...] = ()
    shading_differences: tuple[ShadingDifferencePicture, ...] = ()
    responses: tuple[ResponsePicture, ...] = ()
    charts: tuple[ChartPicture, ...] = ()
    rendered: tuple[RenderedPoints, ...] = ()
