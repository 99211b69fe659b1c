"""Dynamic range of the whole camera: stray light from the lens raises the noise that dark signals have to stand out of.

`camera_dynamic_range` is scene-referenced: the signal is the scene's own light, the noise is that of scene and flare.
`iso15739_like` divides by the noise of a black patch instead; it is no measurement by the standard (EMVA1288 15).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.figures.ratios import Ratio, ratio
from fullwell.model.photon_transfer import noise_variance, signal_at_snr, signal_at_snr_gradient
from fullwell.units import DN, DN2, Measured, combined_dof

QUALITY_DECIBELS: Final = (0.0, 10.0, 20.0, 30.0)
"""Signal-to-noise ratios, in dB, that a camera's dynamic range is told for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraDynamicRange:
    """Dynamic range with flare, for one threshold.

    Parameters
    ----------
    snr
        The threshold [1].
    threshold_signal
        The scene's signal at the threshold, flare not included [DN].
    range
        Largest signal over it.

    """

    snr: float
    threshold_signal: Measured
    range: Ratio


def camera_dynamic_range(
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    saturation: Measured,
    flare: Measured,
    *,
    snr: float = 1.0,
    dof: float | None = None,
) -> CameraDynamicRange:
    """Return the scene-referenced dynamic range by the delta method (METHOD 7).

    Parameters
    ----------
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] of a single frame and their covariance, shapes (3,) and (3, 3); the error of the
        offset left out, see Notes.
    saturation
        Saturation signal above the black level, with its error where it has one [DN].
    flare
        Stray light as a fraction of the largest signal, `FlareFit.flare_at_offset` [1].
    snr
        Threshold.
    dof
        Degrees of freedom of the covariance; None for many.

    Returns
    -------
    CameraDynamicRange

    Raises
    ------
    ValueError
        Where the model never crosses the threshold.

    Notes
    -----
    An offset that is wrong by d makes A too large by B d + C d^2 and the flare too small by d: noise as a function of
    the scene's light stays the same, so the offset's error drops out.

    """
    flare_dn = flare.value * saturation.value
    dark, shot, fixed = (float(value) for value in coefficients)
    shifted = {
        "dark": dark + shot * flare_dn + fixed * flare_dn**2,
        "shot": shot + 2.0 * fixed * flare_dn,
        "fixed_pattern": fixed,
    }
    signal = signal_at_snr(snr, **shifted)
    if not (math.isfinite(signal) and signal > 0.0):
        raise ValueError(f"the noise model with flare never reaches a signal-to-noise ratio of {snr:g}")
    to_shifted = np.array([[1.0, flare_dn, flare_dn**2], [0.0, 1.0, 2.0 * flare_dn], [0.0, 0.0, 1.0]])
    gradient = signal_at_snr_gradient(snr, **shifted)
    by_coefficients = gradient @ to_shifted
    by_flare = float(gradient @ np.array([shifted["shot"], 2.0 * fixed, 0.0]))
    model_error = math.sqrt(float(by_coefficients @ covariance @ by_coefficients)) / signal
    flare_error = by_flare * saturation.value * (flare.std_error or 0.0) / signal
    by_saturation = 1.0 / saturation.value - by_flare * flare.value / signal
    saturation_error = abs(by_saturation) * (saturation.std_error or 0.0)
    threshold_parts = ((model_error, dof), (flare_error, flare.dof))
    parts = (*threshold_parts, (saturation_error, saturation.dof))
    return CameraDynamicRange(
        snr=snr,
        threshold_signal=Measured.student(
            signal, signal * math.hypot(model_error, flare_error), combined_dof(*threshold_parts), DN
        ),
        range=ratio(
            saturation.value / signal, math.hypot(model_error, flare_error, saturation_error), combined_dof(*parts)
        ),
    )


def scene_snr_curve(signal_dn: ArrayLike, coefficients: NDArray[np.float64], *, flare_dn: float) -> NDArray[np.float64]:
    """Return s / sqrt(noise variance at s + flare) for signals s of the scene, any shape [1]."""
    level = np.asarray(signal_dn, np.float64)
    dark, shot, fixed = (float(value) for value in coefficients)
    return level / np.sqrt(noise_variance(level + flare_dn, dark=dark, shot=shot, fixed_pattern=fixed))


def iso15739_like(saturation: Measured, variance_dn2: Measured, *, flare_dn: float = 0.0) -> Ratio:
    """Return the clipping level over the noise at a black patch, linear response (METHOD 7; EMVA1288 15).

    Parameters
    ----------
    saturation
        Clipping level above black [DN].
    variance_dn2
        Variance of the black patch, temporal where there are frames to tell, with its error; see `patch_variance`
        [DN^2].
    flare_dn
        Stray light in the clipping level: the scene's own light alone counts [DN].

    Raises
    ------
    ValueError
        Where the patch has no noise or nothing is left of the clipping level.

    """
    clip = saturation.value - flare_dn
    if variance_dn2.value <= 0.0 or clip <= 0.0:
        raise ValueError("this dynamic range needs a black patch with noise and a clipping level above the flare")
    clip_error = (saturation.std_error or 0.0) / clip
    noise_error = 0.5 * (variance_dn2.std_error or 0.0) / variance_dn2.value
    return ratio(
        clip / math.sqrt(variance_dn2.value),
        math.hypot(clip_error, noise_error),
        combined_dof((clip_error, saturation.dof), (noise_error, variance_dn2.dof)),
    )


def patch_variance(variance_dn2: float, dof: float) -> Measured:
    """Return the measured variance of one patch with its error, variance sqrt(2 / dof) [DN^2]."""
    return Measured.student(variance_dn2, variance_dn2 * math.sqrt(2.0 / dof), dof, DN2)


def patch_nearest(densities: ArrayLike, density: float) -> int:
    """Return the index of the patch nearest to a density, for example 2.0; NaN densities do not count."""
    return int(np.nanargmin(np.abs(np.asarray(densities, np.float64) - density)))
