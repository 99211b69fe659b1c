"""How much less light a channel sees than the first green one (METHOD 1.10)."""

import math

import numpy as np
from numpy.typing import ArrayLike

from fullwell.units import ONE, Measured, combined_dof


def channel_ratio(
    signal_dn: ArrayLike,
    variance_of_mean_dn2: ArrayLike,
    reference_dn: ArrayLike,
    reference_variance_dn2: ArrayLike,
    *,
    offset_std_error_dn: float = 0.0,
) -> Measured:
    """Return the ratio of the mean signals of two channels over the same patches (``mean-ratio``).

    Parameters
    ----------
    signal_dn, variance_of_mean_dn2
        Mean above black of each patch in the channel and its variance, patches that clip in either channel left out,
        shape (N,) [DN, DN^2].
    reference_dn, reference_variance_dn2
        The same patches in the channel to compare with, by convention G1 [DN, DN^2].
    offset_std_error_dn
        Standard error of each channel's offset [DN].

    Returns
    -------
    Measured
        Sum over sum. Its error is the larger of what the noise of the means and the scatter of the patches about one
        ratio say, the latter with the degrees of freedom of the few light patches that dominate it [1].

    Raises
    ------
    ValueError
        Without patches, or where the reference has no signal.

    """
    signal, variance, reference, reference_variance = (
        np.asarray(values, np.float64)
        for values in (signal_dn, variance_of_mean_dn2, reference_dn, reference_variance_dn2)
    )
    total = float(reference.sum())
    if signal.size == 0 or total <= 0.0:
        raise ValueError("a ratio of channels needs patches with a signal in the reference channel")
    ratio = float(signal.sum()) / total
    expected = variance + ratio**2 * reference_variance
    by_noise = math.sqrt(float(expected.sum())) / total
    error, dof = by_noise, None
    if signal.size > 1:
        scatter = (signal - ratio * reference) ** 2 * signal.size / (signal.size - 1)
        by_scatter = math.sqrt(float(scatter.sum())) / total
        if by_scatter > by_noise:
            share = reference**2 / float(np.sum(reference**2))
            error, dof = by_scatter, max(1.0 / float(np.sum(share**2)) - 1.0, 1.0)
    by_offset = offset_std_error_dn * signal.size * math.hypot(1.0, ratio) / total
    return Measured.student(ratio, math.hypot(error, by_offset), combined_dof((error, dof), (by_offset, None)), ONE)
