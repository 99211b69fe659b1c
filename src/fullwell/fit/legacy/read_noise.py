"""The Pixel study's two flows of read noise, of a burst and of each repeat (METHOD 3.2)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.statistics.series import LegacyBurst
from fullwell.units import DN, Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyReadNoise:
    """The two flows of the Pixel study, quantization not removed [DN].

    Parameters
    ----------
    pair_difference
        Flow 1: root mean square over pairs of the spatial noise of the difference, over sqrt 2.
    burst_mean
        Flow 2: root mean square over frames of the spatial noise of frame minus burst mean; flow 1 times
        sqrt((L - 1) / L).

    """

    pair_difference: Measured
    burst_mean: Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadNoiseRepeats:
    """Both published read-noise flows, one value per repeat.

    Parameters
    ----------
    iso
        None where nothing says it.
    frames
        Names of the repeats, in order, at most five.
    flow1_dn
        Root mean square over the pairs with this frame of the spatial noise of the difference over sqrt 2; the root
        mean square over repeats is the published flow 1, shape (L,) [DN].
    flow2_dn
        Spatial noise of burst mean minus frame, shape (L,) [DN].

    """

    iso: float | None
    frames: tuple[str, ...]
    flow1_dn: NDArray[np.float64]
    flow2_dn: NDArray[np.float64]


def legacy_read_noise(burst: LegacyBurst) -> LegacyReadNoise:
    """Return both read-noise flows of the Pixel study (METHOD 3.2)."""
    return LegacyReadNoise(
        pair_difference=Measured.exact(math.sqrt(burst.pair_variance / 2.0), DN),
        burst_mean=Measured.exact(math.sqrt(burst.residual_variance), DN),
    )


def read_noise_repeats(
    frames: Sequence[str], frame_sums: Sequence[int], products: Sequence[Sequence[int]], *, iso: float | None, n: int
) -> ReadNoiseRepeats:
    """Return both flows of each repeat from exact sums over the whole mosaic (METHOD 3.2).

    Parameters
    ----------
    frames
        Names of L frames, at least two.
    frame_sums
        Sum over pixels of each [DN].
    products
        Sum over pixels of the product of each two frames, L x L [DN^2].
    iso
        Of the burst.
    n
        Pixels of the mosaic, at least two.

    """
    count = len(frames)
    every = range(count)
    # n^2 times the covariance of the frames, without rounding.
    covariance = [[n * products[i][j] - frame_sums[i] * frame_sums[j] for j in every] for i in every]
    scale = n * (n - 1)
    flow1: list[float] = []
    flow2: list[float] = []
    for j in every:
        pairs = sum(covariance[i][i] - 2 * covariance[i][j] + covariance[j][j] for i in every)
        flow1.append(math.sqrt(pairs / (scale * 2 * (count - 1))))
        # burst mean minus frame j is the mean over all frames of their differences from it
        residual = sum(
            covariance[i][k] - covariance[i][j] - covariance[k][j] + covariance[j][j] for i in every for k in every
        )
        flow2.append(math.sqrt(residual / (scale * count**2)))
    return ReadNoiseRepeats(iso=iso, frames=tuple(frames), flow1_dn=np.array(flow1), flow2_dn=np.array(flow2))
