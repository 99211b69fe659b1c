"""What a shading surface is fitted to: bins of one plane, their variances told apart (METHOD 6.1)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.bins import Bins

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingData:
    """Bins of one CFA plane of one burst on a grid of V rows and H columns.

    Parameters
    ----------
    rows, columns
        Centres of the bins along each axis, shapes (V,) and (H,) [pixel of the plane, from 0].
    signal_dn
        Mean of each bin above black, shape (V, H) [DN]; NaN where the bin is left out. May be negative.
    temporal_variance_dn2
        Variance of each bin's mean by temporal noise, shape (V, H), above zero where the bin is used [DN^2].
    fixed_variance
        Variance of each bin's mean by PRNU, relative to the squared signal, shape (V, H) [1].
    plane_shape
        Rows and columns of the plane [pixel].
    pitch_um
        Distance of two pixels of the plane, twice the sensor's pitch behind a Bayer mosaic [um]; None where unknown.
    focal_length_mm
        Stated focal length [mm]; None where unknown.

    """

    rows: FloatArray
    columns: FloatArray
    signal_dn: FloatArray
    temporal_variance_dn2: FloatArray
    fixed_variance: FloatArray
    plane_shape: tuple[int, int]
    pitch_um: float | None = None
    focal_length_mm: float | None = None

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which bins count, shape (V, H)."""
        return np.isfinite(self.signal_dn)

    @property
    def focal_length_pixels(self) -> float | None:
        """Stated focal length [pixel of the plane]; None where it or the pitch is unknown."""
        if self.focal_length_mm is None or self.pitch_um is None:
            return None
        return 1000.0 * self.focal_length_mm / self.pitch_um


def shading_data(
    bins: Bins,
    *,
    black_dn: float,
    temporal_variance_dn2: Callable[[FloatArray], FloatArray] | FloatArray | float,
    frames: int,
    prnu: float,
    pitch_um: float | None = None,
    focal_length_mm: float | None = None,
) -> ShadingData:
    """Return bins as shading is fitted to them: black subtracted, each with its variances (METHOD 6.1).

    Parameters
    ----------
    bins
        Of one plane of one burst.
    black_dn
        Black level of the plane [DN].
    temporal_variance_dn2
        Temporal variance of one pixel in one frame [DN^2]: a function of the signal above black [DN], an array of the
        bins' shape, or one number.
    frames
        Frames in the burst.
    prnu
        Photo-response non-uniformity as a fraction [1].
    pitch_um
        Distance of two pixels of the plane [um].
    focal_length_mm
        Stated focal length [mm].

    Returns
    -------
    ShadingData
        Bins without pixels, or with a mean that is not finite, are left out.

    Raises
    ------
    ValueError
        Where no bin is left, or a temporal variance is not above zero.

    """
    used = (bins.n > 0) & np.isfinite(bins.mean)
    if not used.any():
        raise ValueError("no bin is left to fit shading to: all are saturated or without sound pixels")
    signal = np.where(used, bins.mean - black_dn, np.nan)
    if callable(temporal_variance_dn2):
        per_frame = temporal_variance_dn2(np.where(used, local_mean(signal), 0.0))
    else:
        per_frame = np.broadcast_to(np.asarray(temporal_variance_dn2, np.float64), signal.shape)
    if not (np.isfinite(per_frame[used]) & (per_frame[used] > 0.0)).all():
        raise ValueError("the temporal variance of a bin is not above zero; give that of one pixel in one frame")
    values = np.where(used, bins.n, 1).astype(np.float64)
    return ShadingData(
        rows=bins.rows,
        columns=bins.columns,
        signal_dn=signal,
        temporal_variance_dn2=np.where(used, per_frame / (values * frames), np.nan),
        fixed_variance=np.where(used, prnu**2 / values, np.nan),
        plane_shape=bins.plane_shape,
        pitch_um=pitch_um,
        focal_length_mm=focal_length_mm,
    )


def local_mean(values: FloatArray) -> FloatArray:
    """Return the mean over 5 x 5 bins around each, fewer at the borders and where some are NaN; NaN where all are."""
    known = np.isfinite(values)
    total = _box(np.where(known, values, 0.0))
    count = _box(known.astype(np.float64))
    return np.divide(total, count, out=np.full(values.shape, np.nan), where=count > 0.5)


def _box(values: FloatArray) -> FloatArray:
    """Return the sums over 5 x 5 values around each."""
    for axis in (0, 1):
        width = [(0, 0), (0, 0)]
        width[axis] = (3, 2)
        running = np.cumsum(np.pad(values, width), axis=axis)
        size = values.shape[axis]
        values = running.take(range(5, size + 5), axis=axis) - running.take(range(size), axis=axis)
    return values
