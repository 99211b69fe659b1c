"""What rounding to whole codes leaves unknown of a temporal variance when the noise is small (METHOD 3.3)."""

import math

from fullwell.fit.read_noise import phase_effect, unrounded_noise
from fullwell.statistics.series import PlaneStatistics


def rounding_error_dn2(plane: PlaneStatistics, variance_dn2: float) -> float:
    """Return one standard error of a temporal variance from the unknown phase of its level within a code [DN^2].

    Noise above about half a code, or levels that differ by as much between pixels, leave nothing of it (METHOD 3.3).
    """
    return phase_effect(unrounded_noise(variance_dn2), spread=plane.fixed_spread) / math.sqrt(2.0)


def phase_aware_dof(plane: PlaneStatistics, variance_dn2: float, dof: float) -> float:
    """Return the degrees of freedom of a temporal variance, lowered by `rounding_error_dn2`."""
    if variance_dn2 <= 0.0:
        return dof
    phase_dn2 = rounding_error_dn2(plane, variance_dn2)
    return 2.0 * variance_dn2**2 / (2.0 * variance_dn2**2 / dof + phase_dn2**2)
