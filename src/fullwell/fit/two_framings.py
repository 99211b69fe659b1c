"""Fixed pattern of the sensor in spite of the chart's texture: two framings of one chart (METHOD 1.9).

A pixel keeps its response, the texture moves with the chart, temporal noise is new in every frame: the covariance of
the relative residuals of two framings, aligned on the sensor, is the squared PRNU alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoFramings:
    """What two framings say together.

    Parameters
    ----------
    prnu_variance
        Squared PRNU, signed [1].
    first_variance, second_variance
        Relative variance in each framing alone, weighted as the covariance: temporal noise and texture included [1].
    neighbour_covariance
        Covariance with the pixels beside, zero but for what is smooth over pixels and common to both framings: light
        that a surface of second order cannot follow, or a shift too small for the texture [1].
    clean
        Whether ``neighbour_covariance`` is zero within three standard errors.
    n
        Pixels in common.

    """

    prnu_variance: Measured
    first_variance: float
    second_variance: float
    neighbour_covariance: Measured
    clean: bool
    n: int


def two_framings(first_dn: Sequence[NDArray[np.float64]], second_dn: Sequence[NDArray[np.float64]]) -> TwoFramings:
    """Return the squared PRNU from pixels that two framings of a chart have in common (METHOD 1.9).

    Parameters
    ----------
    first_dn, second_dn
        Signal above black of one CFA plane, one array per region that lies inside a patch in both framings: the same
        pixels of the sensor in both, each of shape (rows, columns), at least 8 x 8. The patches may differ between the
        framings; the chart has to be shifted by 3 pixels or more [DN].

    Returns
    -------
    TwoFramings
        Regions are weighted by inverse variance, sqrt((v1 v2 + c^2) / nu) being the standard error of each.

    Raises
    ------
    ValueError
        Without regions, or where two that belong together differ in shape, are too small or not positive.

    Notes
    -----
    DSNU is common to both framings as well and adds DSNU^2 / (S1 S2): give no regions near black.

    """
    raise NotImplementedError
