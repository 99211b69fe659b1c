"""Stray light, from the densities of a chart and an offset that other evidence identifies (METHOD 2.2, 2.3).

Flare and offset add to every patch alike: one exposure of one chart tells their sum, never both.
"""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class FlareFit:
    """Signal = response (10^-(density - lowest density) + flare), fitted to one channel.

    Parameters
    ----------
    flare
        Stray light as a fraction of the signal that the lightest patch has without it, signed; the error of the offset
        is in its own [1].
    flare_at_offset
        The same for the offset as it is given: for `camera_dynamic_range`, where an error of the offset drops out [1].
    response
        Signal of the lightest patch without stray light [DN].
    density_scatter
        What patches differ from their densities by, beyond their noise, as a standard deviation of density; it is in
        the errors.
    chi_square, dof
        Of the residuals over their noise alone, before ``density_scatter`` was allowed for.

    """

    flare: Measured
    flare_at_offset: Measured
    response: Measured
    density_scatter: float
    chi_square: float
    dof: int


def fit_flare(
    signal_dn: ArrayLike,
    std_error_dn: ArrayLike,
    densities: ArrayLike,
    *,
    offset_std_error_dn: float,
    identified: bool,
) -> FlareFit:
    """Fit stray light to the densities of a chart (METHOD 2.2).

    Parameters
    ----------
    signal_dn
        Mean above the identified offset of each patch of one channel, clipped patches left out, shape (N,) [DN].
    std_error_dn
        Of each mean, that of the offset not included, shape (N,) [DN].
    densities
        Density of each patch, shape (N,).
    offset_std_error_dn
        Standard error of the offset [DN].
    identified
        Whether other evidence than this chart's densities identifies the offset (`FusedLevel.identified`).

    Returns
    -------
    FlareFit

    Raises
    ------
    ValueError
        Where the offset is not identified: flare and offset then cannot be told apart; with fewer than three patches,
        or fewer than three different densities.

    """
    raise NotImplementedError
