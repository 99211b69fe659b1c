"""What the published page on sensor noise reads off the patches of one chart, as it does: no errors, only brackets.

Source: the Imatest page on sensor noise. METHOD 2.2, 7 and 8 say by how much each is off.
"""

from dataclasses import dataclass
from typing import Final

from numpy.typing import ArrayLike

from fullwell.units import Measured

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
    raise NotImplementedError


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
    raise NotImplementedError


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
    raise NotImplementedError
