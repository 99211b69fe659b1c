"""What the published page on sensor noise reads off the patches of one chart, as it does: no errors, only brackets.

Source: the Imatest page on sensor noise. METHOD 2.2, 7 and 8 say by how much each is off.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from fullwell.fit.legacy.imatest import legacy_offset_ratio
from fullwell.units import DECIBEL, DN, ELECTRON, ONE, STOP, Measured

PUBLISHED_RATIO: Final = 1e5
"""Published ratio of brightest over darkest patch, found there by trial and error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyOffset:
    """The published offset.

    Parameters
    ----------
    offset
        The level that makes brightest over darkest patch equal ``ratio``, without error [DN].
    ratio
        The ratio that was used: the one asked for, or that of the chart's densities where that is less [1].

    """

    offset: Measured
    ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacySaturation:
    """Signal of the patch of largest total noise.

    Parameters
    ----------
    signal
        Above black, its interval the levels of the neighbours that bracket it, no standard error [DN].
    electrons
        The same over the system gain [e-].
    patch
        Index of the patch in the arguments.
    flags
        ``lower-bound`` where it is the brightest patch.

    """

    signal: Measured
    electrons: Measured
    patch: int
    flags: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LegacyRange:
    """Dynamic range as the difference of two patches' densities.

    Parameters
    ----------
    decibel, stops
        From the patch of largest noise to the patch whose signal-to-noise ratio is nearest to the threshold; the
        interval is what the neighbours of both allow, no standard error [dB, EV].
    brightest, darkest
        Indices of the two patches in the arguments.
    flags
        ``lower-bound`` where a patch is at the end of its scale.

    """

    decibel: Measured
    stops: Measured
    brightest: int
    darkest: int
    flags: tuple[str, ...]


def legacy_offset(
    means_dn: ArrayLike, densities: ArrayLike | None = None, *, ratio: float = PUBLISHED_RATIO
) -> LegacyOffset:
    """Return the offset of the published optimizer: it takes all flare for pedestal (METHOD 2.2).

    Parameters
    ----------
    means_dn
        Mean of each patch, black level included, of one channel or of all, shape (N,) [DN].
    densities
        Density of each; where given, the ratio is at most 10^(largest - smallest), as published.
    ratio
        Brightest over darkest patch once the offset is taken off; above 1.

    """
    means = np.asarray(means_dn, np.float64)
    if densities is not None:
        known = np.asarray(densities, np.float64)
        ratio = min(ratio, 10.0 ** float(np.nanmax(known) - np.nanmin(known)))
    if ratio <= 1.0:
        raise ValueError("the ratio of brightest over darkest patch has to be above 1")
    return LegacyOffset(
        offset=legacy_offset_ratio(float(means.min()), float(means.max()), ratio=ratio), ratio=float(ratio)
    )


def legacy_max_noise_patch(signal_dn: ArrayLike, variance_dn2: ArrayLike, *, system_gain: float) -> LegacySaturation:
    """Return the signal of the patch with the largest total noise, the published saturation (METHOD 7).

    Parameters
    ----------
    signal_dn
        Mean above black of each patch, clipped ones too, of one channel, shape (N,) [DN].
    variance_dn2
        Single-frame variance of each [DN^2].
    system_gain
        K of the published fit, D k_shot^2 [DN/e-].

    """
    signal, variance = np.asarray(signal_dn, np.float64), np.asarray(variance_dn2, np.float64)
    order = np.argsort(signal, kind="stable")
    place = int(np.argmax(variance[order]))
    patch = int(order[place])
    last = place == signal.size - 1
    around = order[max(place - 1, 0) : place + 2]
    level = Measured(
        value=float(signal[patch]), unit=DN, ci95=(float(signal[around].min()), float(signal[around].max()))
    )
    if last:
        level = Measured.exact(level.value, DN)
    return LegacySaturation(
        signal=level,
        electrons=level.scaled(1.0 / system_gain, ELECTRON),
        patch=patch,
        flags=("lower-bound",) if last else (),
    )


def legacy_patch_range(
    signal_dn: ArrayLike, variance_dn2: ArrayLike, densities: ArrayLike | None = None, *, snr: float = 1.0
) -> LegacyRange | None:
    """Return the published dynamic range, read off the patches of one channel (METHOD 7, 8).

    Parameters
    ----------
    signal_dn, variance_dn2
        As in `legacy_max_noise_patch`.
    densities
        Density of each patch, shape (N,); without them the decades between the signals stand in.
    snr
        The threshold.

    Returns
    -------
    LegacyRange or None
        None where no patch below the one of largest noise has a signal above zero.

    """
    signal, variance = np.asarray(signal_dn, np.float64), np.asarray(variance_dn2, np.float64)
    seen = (signal > 0.0) & (variance > 0.0)
    density = -np.log10(np.where(seen, signal, np.nan)) if densities is None else np.asarray(densities, np.float64)
    seen &= np.isfinite(density)
    if not seen.any():
        return None
    order = np.flatnonzero(seen)[np.argsort(density[seen], kind="stable")]
    top = int(np.argmax(variance[order]))
    excess = np.log(signal[order] / np.sqrt(variance[order]) / snr)
    below = np.arange(top + 1, order.size)
    if below.size == 0:
        return None
    nearest = int(below[np.argmin(np.abs(excess[below]))])
    under = below[excess[below] < 0.0]
    flags = ("lower-bound",) if top == 0 or under.size == 0 else ()
    scale = density[order]
    decades = float(scale[nearest] - scale[top])
    bracket = None
    if not flags:
        crossing = int(under[0])
        low = min(scale[crossing - 1], scale[nearest]) - scale[top + 1]
        high = max(scale[crossing], scale[nearest]) - scale[top - 1]
        bracket = (max(float(low), 0.0), float(high))
    in_decades = Measured(value=decades, unit=ONE, ci95=bracket)
    return LegacyRange(
        decibel=in_decades.scaled(20.0, DECIBEL),
        stops=in_decades.scaled(math.log2(10.0), STOP),
        brightest=int(order[top]),
        darkest=int(order[nearest]),
        flags=flags,
    )
