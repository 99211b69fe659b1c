"""How much a simulated lens shades flats, by the definitions of the glossary."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell
from fullwell.simulate.config import SimulationConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class Shading:
    """Signal of an even field relative to its maximum in one CFA plane [1].

    Parameters
    ----------
    corner
        Mean of the four corner pixels of the plane.
    edge_x, edge_y
        Mean of the first and last column in the middle row, of the first and last row in the middle column.

    """

    corner: float
    edge_x: float
    edge_y: float


def true_shading(config: SimulationConfig) -> tuple[Shading, ...]:
    """Return the shading of each CFA site, row-major, flare included."""
    sensor, lens = config.sensor, config.lens
    illumination = lens.map_for(sensor)
    period = cell(sensor.cfa)
    found: list[Shading] = []
    for site, response in enumerate(sensor.response):
        plane = illumination[site // period :: period, site % period :: period]
        flare = lens.flare * response
        top = float(plane.max()) + flare
        corner, edge_x, edge_y = (
            (float(places.mean(dtype=np.float64)) + flare) / top
            for places in (plane[np.ix_((0, -1), (0, -1))], _ends(plane), _ends(plane.T))
        )
        found.append(Shading(corner=corner, edge_x=edge_x, edge_y=edge_y))
    return tuple(found)


def _ends(plane: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return both ends of the middle row; of an even number of rows those of the two in the middle."""
    rows = plane.shape[0]
    return plane[(rows - 1) // 2 : rows // 2 + 1, (0, -1)]
