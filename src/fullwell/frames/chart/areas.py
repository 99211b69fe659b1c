"""Even areas of a picture that are shaped like patches: connected, without edges inside, as compact as rectangles."""

from dataclasses import dataclass
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fullwell.frames.chart.preview import Preview

_SLOPES: Final = (0.012, 0.025, 0.05, 0.1)
"""Slopes of the logarithm of light that count as an edge, each tried [1/pixel]."""
_LEAST: Final = 9
"""Pixels of an area at least; below, its moments say nothing."""
_MOST: Final = 0.08
"""Share of the picture that a patch covers at most."""
_COMPACT: Final = (0.82, 1.12)
"""Area over that of the rectangle with the same second moments: 1 for rectangles, 1.05 for ellipses."""
_SLIMMEST: Final = 10.0
"""Length over width of an area at most."""
_SAME: Final = 0.25
"""Distance of the middles of one area found twice, as a share of its edge."""
_ALIKE: Final = 1.8
"""Ratio of the sizes of one area found twice; two steps that run together are more than that over one."""
_COUNT: Final = 500
"""Areas that are kept, the most compact first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Areas:
    """Even areas; positions and sizes in pixels of the preview.

    Parameters
    ----------
    centre
        x and y, shape (n, 2).
    moments
        Covariance of x and y over the area, shape (n, 2, 2).
    size
        Pixels, shape (n,).
    light
        Logarithm of the mean light, shape (n,).

    """

    centre: NDArray[np.float64]
    moments: NDArray[np.float64]
    size: NDArray[np.float64]
    light: NDArray[np.float64]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.size)

    def taken(self, index: NDArray[np.intp]) -> "Areas":
        """Return some of them."""
        return Areas(
            centre=self.centre[index], moments=self.moments[index], size=self.size[index], light=self.light[index]
        )


def even_areas(picture: Preview) -> Areas:
    """Return the areas of a picture that may be patches, each once."""
    light = np.log(np.maximum(picture.light, 0.0) + picture.floor)
    smooth = ndimage.gaussian_filter(light, 0.8)
    down, across = np.gradient(smooth)
    slope = np.hypot(down, across)
    found = [_compact(slope < limit, light) for limit in _SLOPES]
    every = Areas(
        centre=np.concatenate([one.centre for one in found]),
        moments=np.concatenate([one.moments for one in found]),
        size=np.concatenate([one.size for one in found]),
        light=np.concatenate([one.light for one in found]),
    )
    return _each_once(every)


def _compact(flat: NDArray[np.bool_], light: NDArray[np.float64]) -> Areas:
    """Return the connected parts of a mask that are shaped like patches."""
    opened = ndimage.binary_opening(flat, np.ones((2, 2), dtype=np.bool_))
    labels = np.zeros(opened.shape, dtype=np.intp)
    count = int(cast("int", ndimage.label(opened, output=labels)))
    size = np.bincount(labels.ravel(), minlength=count + 1).astype(np.float64)
    own = (size >= _LEAST) & (size <= _MOST * flat.size)
    own[0] = False
    rows, columns = np.nonzero(own[labels])
    label = labels[rows, columns]

    def mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.bincount(label, weights=values, minlength=count + 1)[own] / size[own]

    x, y = mean(columns.astype(np.float64)), mean(rows.astype(np.float64))
    place = np.cumsum(own) - 1
    dx, dy = columns - x[place[label]], rows - y[place[label]]
    xx, xy, yy = mean(dx * dx) + 1 / 12, mean(dx * dy), mean(dy * dy) + 1 / 12
    areas = Areas(
        centre=np.column_stack((x, y)),
        moments=np.stack((np.column_stack((xx, xy)), np.column_stack((xy, yy))), axis=1),
        size=size[own],
        light=mean(light[rows, columns]),
    )
    determinant = np.maximum(xx * yy - xy * xy, 1e-9)
    compact = areas.size / (12.0 * np.sqrt(determinant))
    half, apart = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    slim = np.sqrt((half + apart) / np.maximum(half - apart, 1e-9))
    good = (compact > _COMPACT[0]) & (compact < _COMPACT[1]) & (slim < _SLIMMEST)
    return areas.taken(np.flatnonzero(good))


def _each_once(areas: Areas) -> Areas:
    """Keep the largest of areas with nearly the same middle."""
    order = np.argsort(-areas.size, kind="stable")
    nearness = np.linalg.inv(areas.moments)
    kept: list[int] = []
    for one in order:
        if len(kept) == _COUNT:
            break
        apart = areas.centre[kept] - areas.centre[one]
        squared = np.einsum("ni,nij,nj->n", apart, nearness[kept], apart)
        same = (squared < 12.0 * _SAME**2) & (areas.size[kept] < _ALIKE * areas.size[one])
        if not same.any():
            kept.append(int(one))
    return areas.taken(np.array(kept, dtype=np.intp))
