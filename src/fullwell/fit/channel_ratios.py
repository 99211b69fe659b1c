"""How much less light a channel sees than the first green one (METHOD 1.10)."""

from numpy.typing import ArrayLike

from fullwell.units import Measured


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
        Its error is the larger of what the noise of the means and the scatter of the patches about one ratio say [1].

    Raises
    ------
    ValueError
        Without patches, or where the reference has no signal.

    """
    raise NotImplementedError
