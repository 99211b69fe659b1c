"""The Pixel study's dark slopes: lines through the frame means of dark frames (METHOD 4.1)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import ALL, MONO, channels
from fullwell.statistics.pixels import line_coefficients
from fullwell.units import DN, DN_PER_SECOND, Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyDarkLine:
    """Ordinary least squares through one frame per exposure, without errors [DN/s, DN]."""

    slope: Measured
    intercept: Measured


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


def legacy_frame_slope(exposure_s: Sequence[float], first_frame_mean_dn: Sequence[float]) -> LegacyDarkLine:
    """Return the Pixel study's dark slope: the first frame of each exposure, ordinary least squares (METHOD 4.1)."""
    slope, intercept = line_coefficients(exposure_s) @ np.asarray(first_frame_mean_dn, np.float64)
    return LegacyDarkLine(
        slope=Measured.exact(float(slope), DN_PER_SECOND), intercept=Measured.exact(float(intercept), DN)
    )


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
    weights = line_coefficients(exposures_s.tolist())
    lines: list[StudyDarkLine] = []
    for channel, levels in _mean_by_channel(means, bursts[0].pixels, cfa):
        slope, intercept = (float(value) for value in weights @ levels)
        lines.append(StudyDarkLine(iso=iso, channel=channel, slope_dn_per_s=slope, intercept_dn=intercept))
    return tuple(lines)


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
