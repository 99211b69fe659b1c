"""How much a lens shades: the surface at the corners and edges of the plane, relative to its maximum."""

from dataclasses import dataclass

from fullwell.fit.shading.data import ShadingData
from fullwell.fit.shading.surface import ShadingModel
from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerAndEdges:
    """Relative illumination, 1 at the maximum of the surface [1].

    Parameters
    ----------
    corner
        Mean over the centres of the four corner pixels of the plane.
    edge_x
        Mean over the first and the last column, in the middle row.
    edge_y
        Mean over the first and the last row, in the middle column.

    """

    corner: Measured
    edge_x: Measured
    edge_y: Measured


def corner_and_edges(model: ShadingModel, *, temporal: bool = False) -> CornerAndEdges:
    """Return corner and edges of a surface; their errors count that of the maximum and all covariances.

    Parameters
    ----------
    model
        A fitted surface.
    temporal
        Errors by temporal noise alone, for comparisons of bursts of one sensor.

    """
    raise NotImplementedError


def residual_rms(model: ShadingModel, data: ShadingData) -> Measured:
    """Return the root mean square of the relative residuals of the bins, noise included [1]."""
    raise NotImplementedError
