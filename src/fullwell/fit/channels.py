"""Whether the colour channels share one photon transfer curve (METHOD 1.10).

They should: read noise and system gain belong to the circuit, not to the dye. Rejection means digital scaling of a
channel in the raw file, or circuits that differ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from fullwell.fit.photon_transfer import PhotonTransferFit, fit_photon_transfer


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelPoints:
    """Photon transfer points of one channel, arguments of `fit_photon_transfer`; each array of shape (N,).

    Parameters
    ----------
    signal_dn
        Mean above the black level [DN].
    variance_dn2
        Variance [DN^2].
    dof
        Its degrees of freedom.
    n
        Pixel values behind each point.

    """

    signal_dn: NDArray[np.float64]
    variance_dn2: NDArray[np.float64]
    dof: NDArray[np.float64]
    n: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedCurve:
    """One curve for all channels, and the test whether they share it.

    Parameters
    ----------
    fit
        To the points of all channels.
    ratio, ratio_dof
        Likelihood ratio against a curve for each channel.
    p_value
        Chance of a larger ratio if the channels share the curve; by F where the curves themselves do not fit.

    """

    fit: PhotonTransferFit
    ratio: float
    ratio_dof: int
    p_value: float


def fit_shared_curve(channels: Sequence[ChannelPoints], *, terms: Literal[2, 3] = 3) -> SharedCurve:
    """Fit all channels together and test against separate fits (METHOD 1.10).

    Parameters
    ----------
    channels
        At least two. Points that do not belong are dropped from each channel first.
    terms
        As in `fit_photon_transfer`.

    """
    clean = [_without_outliers(points, terms) for points in channels]
    apart = [_fit(points, terms) for points in clean]
    together = _fit(_joined(clean), terms)
    ratio = max(together.deviance - sum(fit.deviance for fit in apart), 0.0)
    ratio_dof = terms * (len(channels) - 1)
    residual_dof = sum(fit.deviance_dof for fit in apart)
    misfit = any(fit.misfit for fit in apart)
    scale = sum(fit.deviance for fit in apart) / residual_dof if misfit else 1.0
    p_value = float(fdtrc(ratio_dof, residual_dof if misfit else 1e9, ratio / ratio_dof / scale))
    return SharedCurve(fit=together, ratio=ratio, ratio_dof=ratio_dof, p_value=p_value)


def _fit(points: ChannelPoints, terms: Literal[2, 3], *, reject_outliers: bool = False) -> PhotonTransferFit:
    return fit_photon_transfer(
        points.signal_dn,
        points.variance_dn2,
        points.dof,
        n=points.n,
        terms=terms,
        reject_outliers=reject_outliers,
    )


def _without_outliers(points: ChannelPoints, terms: Literal[2, 3]) -> ChannelPoints:
    used = _fit(points, terms, reject_outliers=True).used
    return ChannelPoints(
        signal_dn=points.signal_dn[used],
        variance_dn2=points.variance_dn2[used],
        dof=np.broadcast_to(points.dof, used.shape)[used],
        n=np.broadcast_to(points.n, used.shape)[used],
    )


def _joined(channels: Sequence[ChannelPoints]) -> ChannelPoints:
    return ChannelPoints(
        signal_dn=np.concatenate([points.signal_dn for points in channels]),
        variance_dn2=np.concatenate([points.variance_dn2 for points in channels]),
        dof=np.concatenate([points.dof for points in channels]),
        n=np.concatenate([points.n for points in channels]),
    )
