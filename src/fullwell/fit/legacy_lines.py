"""The Pixel study's read noise per repeat, its dark slopes, its std-against-exposure line, its volts (METHOD 3.2, 5.3).

From frame means and exact products of frames; the corrected figures are measured elsewhere.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import ALL, MONO, channels

_CONTAINER: Final = 65535.0
"""What im2double divides 16-bit codes by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VoltScale:
    """How the study turned DN into volts: swings rounded, over 2^bits in one place and over the white level in another.

    Parameters
    ----------
    swing_v
        Voltage swing [V].
    bit_depth, white_level
        Of the codes [bit], [DN].

    """

    swing_v: float
    bit_depth: int
    white_level: float

    @property
    def code_bits(self) -> int:
        """Return the bits of a code: those that the white level needs where files store 10 bits in 16 [bit]."""
        return min(self.bit_depth, int(self.white_level).bit_length())

    def read_noise_v(self, noise_dn: float) -> float:
        """Return read noise as the study's dv_to_v (.4591 / 1024) [V]."""
        return noise_dn * (round(self.swing_v, 4) / 2**self.code_bits)

    def level_v(self, level_dn: float) -> float:
        """Return a level or a slope as its scripts for the dark (.459 / 1023) [V]."""
        return level_dn * round(self.swing_v, 3) / self.white_level


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


@dataclass(frozen=True, slots=True, kw_only=True)
class DarkFrames:
    """Frame means of one dark burst.

    Parameters
    ----------
    exposures_s
        Exposure of each frame, shape (L,) [s].
    frame_means_dn
        In the order of the frames' names, one column per CFA site, row-major, shape (L, sites) [DN].
    pixels
        Pixels of each plane, shape (sites,).

    """

    exposures_s: NDArray[np.float64]
    frame_means_dn: NDArray[np.float64]
    pixels: NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyDarkLine:
    """polyfit of dark frame means against exposure.

    Parameters
    ----------
    channel
        ``all``, ``R``, ``G``, ``B``; or ``mono``.
    slope_dn_per_s, intercept_dn
        [DN/s], [DN].

    """

    iso: float | None
    channel: str
    slope_dn_per_s: float
    intercept_dn: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StdLine:
    """polyfit of the spatial standard deviation of shading-corrected frames against exposure: the study's DSNU.

    Parameters
    ----------
    exposure_s, std_dn
        One per frame, shape (n,) [s], [DN].
    slope_dn_per_s, intercept_dn
        The line [DN/s], [DN].

    """

    exposure_s: NDArray[np.float64]
    std_dn: NDArray[np.float64]
    slope_dn_per_s: float
    intercept_dn: float

    @property
    def as_published(self) -> float:
        """Return the intercept of frames that im2double had divided by 65535, which was then taken for DN."""
        return self.intercept_dn / _CONTAINER


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


def study_dark_lines(
    bursts: Sequence[DarkFrames], *, iso: float | None, cfa: str, every_frame: bool
) -> tuple[StudyDarkLine, ...]:
    """Return the study's dark slopes: all, R, G, B; or mono alone.

    Parameters
    ----------
    bursts
        Dark bursts of one ISO, at least two different exposures.
    iso, cfa
        Of the bursts.
    every_frame
        Whether all frames enter, as the study did at its lowest ISO, or the first by name of each exposure.

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    taken = slice(None) if every_frame else slice(1)
    exposures_s = np.concatenate([burst.exposures_s[taken] for burst in bursts])
    means = np.concatenate([burst.frame_means_dn[taken] for burst in bursts])
    weights = line_weights(exposures_s)
    lines: list[StudyDarkLine] = []
    for channel, levels in _mean_by_channel(means, bursts[0].pixels, cfa):
        slope, intercept = (float(value) for value in weights @ levels)
        lines.append(StudyDarkLine(iso=iso, channel=channel, slope_dn_per_s=slope, intercept_dn=intercept))
    return tuple(lines)


def fit_std_line(exposure_s: Sequence[float], std_dn: Sequence[float]) -> StdLine:
    """Fit the spatial standard deviation of corrected frames against exposure (METHOD 5.3).

    Parameters
    ----------
    exposure_s, std_dn
        One per frame [s], [DN].

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    time, std = np.asarray(exposure_s, np.float64), np.asarray(std_dn, np.float64)
    slope, intercept = (float(value) for value in line_weights(time) @ std)
    return StdLine(exposure_s=time, std_dn=std, slope_dn_per_s=slope, intercept_dn=intercept)


def line_weights(exposures_s: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return slope and intercept of ordinary least squares as weights of the values, shape (2, K).

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    time = np.asarray(exposures_s, np.float64)
    if np.unique(time).size < 2:
        raise ValueError("the published lines need frames of two or more different exposures")
    centred = time - time.mean()
    slope = centred / float(centred @ centred)
    return np.stack([slope, 1.0 / time.size - time.mean() * slope])


def _mean_by_channel(
    means: NDArray[np.float64], pixels: NDArray[np.int64], cfa: str
) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield the level of each channel, shape (L,), from means per CFA site, shape (L, sites)."""
    if cfa == MONO:
        yield MONO, means[:, 0]
        return
    planes = {name: means[:, site] for site, name in enumerate(channels(cfa))}
    yield ALL, means @ pixels / pixels.sum()
    yield "R", planes["R"]
    yield "G", (planes["G1"] + planes["G2"]) / 2.0
    yield "B", planes["B"]
