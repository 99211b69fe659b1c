"""Photon-transfer points: signal and temporal variance per burst and channel, from the tiles that are admitted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.correlated_noise import dof_divisor
from fullwell.fit.variance_components import component
from fullwell.statistics.series import PlaneStatistics, TileStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.levels import ChannelLevels
from fullwell.workflow.measure.rounding import phase_aware_dof

MAX_CLIPPED_FRACTION = 1e-3  # METHOD 1.11: variance bias -0.19 % there


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferPoint:
    """One burst of one channel.

    Parameters
    ----------
    burst, channel
        What the point was measured on.
    signal_dn
        Mean above black over the admitted tiles [DN].
    plane_signal_dn
        Mean above black over the whole plane, clipped tiles included [DN].
    variance_dn2
        Temporal variance, quantization and read noise included, light flicker removed [DN^2]; NaN for one frame.
    dof
        Degrees of freedom of the variance, lowered where rounding at an unknown phase of the code moves it
        (METHOD 3.3).
    n
        Pixel values behind the point.
    clipped_fraction
        Share of all pixel values of the plane on the white level.
    admitted
        Whether at least one tile is free of clipping and the variance is known.

    """

    burst: Burst
    channel: str
    signal_dn: float
    plane_signal_dn: float
    variance_dn2: float
    dof: float
    n: int
    clipped_fraction: float
    admitted: bool


def clipped_share(tiles: TileStatistics, white_dn: float | None, frames: int) -> NDArray[np.float64]:
    """Return per tile the share of pixel values on the white level, shape (tile rows, tile columns)."""
    if white_dn is None:
        return np.zeros(tiles.n.shape)
    return np.where(tiles.highest >= white_dn, tiles.n_highest / (tiles.n * frames), 0.0)


def admitted_tiles(plane: PlaneStatistics, white_dn: float | None) -> NDArray[np.bool_]:
    """Tell which tiles clip at neither rail (METHOD 1.11) and have a temporal variance, shape as theirs."""
    tiles = plane.tiles
    on_zero = np.where(tiles.lowest == 0, tiles.n_lowest / (tiles.n * plane.frames), 0.0)
    clipped = np.maximum(clipped_share(tiles, white_dn, plane.frames), on_zero)
    return (clipped <= MAX_CLIPPED_FRACTION) & (tiles.temporal_dof > 0)


def transfer_point(burst: Burst, levels: ChannelLevels) -> TransferPoint:
    """Pool the admitted tiles of one burst and channel."""
    plane = burst.plane(levels.channel)
    tiles = plane.tiles
    clipped = clipped_share(tiles, levels.white_dn, plane.frames)
    chosen = admitted_tiles(plane, levels.white_dn)
    pixels = int(tiles.n[chosen].sum())
    admitted = pixels > 0 and plane.frames > 1
    weights = tiles.temporal_dof[chosen]
    variance = float((weights * tiles.temporal_variance[chosen]).sum() / weights.sum()) if admitted else float("nan")
    mean = float((tiles.n[chosen] * tiles.mean[chosen]).sum() / pixels) if pixels else plane.mean
    return TransferPoint(
        burst=burst,
        channel=levels.channel,
        signal_dn=mean - levels.black_dn,
        plane_signal_dn=plane.mean - levels.black_dn,
        variance_dn2=variance,
        dof=phase_aware_dof(plane, variance, pooled_dof(weights, tiles.temporal_variance[chosen])) if admitted else 0.0,
        n=pixels * plane.frames,
        clipped_fraction=float((clipped * tiles.n).sum() / tiles.n.sum()),
        admitted=admitted and variance > 0.0,
    )


def pooled_dof(dof: NDArray[np.int64], variances: NDArray[np.float64]) -> float:
    """Return the degrees of freedom of variances pooled by theirs: fewer than their sum where tiles differ in light."""
    whole, squares = float((dof * variances).sum()), float((dof * variances**2).sum())
    return whole**2 / squares if squares > 0.0 else float(dof.sum())


def correlation_inflation(plane: PlaneStatistics, variance_dn2: float) -> float:
    """Return how much row and column noise widen the scatter of a variance (METHOD 1.8).

    Parameters
    ----------
    plane
        The unlit plane the row and column components are taken from.
    variance_dn2
        Temporal variance of the point in question [DN^2].

    """
    rows, columns = (component(effect, plane.mean_squares, plane.shape).value for effect in ("tv", "th"))
    return dof_divisor(
        rows=plane.rows,
        columns=plane.columns,
        row_share=rows / variance_dn2,
        column_share=columns / variance_dn2,
    )


def unlit_for_transfer(bursts: IsoBursts, channel: str) -> tuple[Burst, ...]:
    """Return the unlit bursts that belong on the photon-transfer curve: no longer exposed than the longest flat."""
    usable = [burst for burst in bursts.unlit if burst.frames > 1 and channel not in bursts.black_clipped]
    if not usable:
        return ()
    longest = max((burst.exposure_s for burst in bursts.flats), default=0.0)
    fitting = [burst for burst in usable if burst.exposure_s <= longest * 1.005]
    return tuple(fitting or usable[:1])


def before_saturation(points: Sequence[TransferPoint]) -> list[bool]:
    """Tell for each point, sorted by signal, whether it lies before the variance turns over.

    A point is past the turn where its variance is more than five standard errors below that of a darker point.
    """
    kept: list[bool] = []
    peak = -np.inf
    for point in points:
        error = point.variance_dn2 * np.sqrt(2.0 / point.dof) if point.dof > 0 else np.inf
        kept.append(bool(point.admitted and point.variance_dn2 > peak - 5.0 * error))
        if kept[-1]:
            peak = max(peak, point.variance_dn2)
    return kept
