"""A small linear picture of a mosaic, in which charts are looked for."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import cell, channels

_QUIET: Final = 8.0
"""Range of a picture over its noise below which nothing is to be seen; pure noise spans about 6.5."""
_FAINT: Final = 0.003
"""Share of the brightest light below which nothing is told apart: flare and an unknown black level reign there."""
_UNSURE: Final = 3e-4
"""Share of the range of codes by which a black level may be wrong."""
_NEARLY_WHITE: Final = 0.97
"""Share of the white level from which on a pixel counts as clipped; binning averages clipped and other pixels."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Preview:
    """A mosaic, binned.

    Parameters
    ----------
    image
        Linear, black subtracted, shape (channels, rows, columns): red, green and blue, or grey alone [DN].
    scale
        Pixels of the mosaic on the edge of one of its pixels.
    floor
        Light below which nothing is told apart [DN].
    noise
        Of a typical pixel of the mean of the channels [DN].
    clipped
        Where a channel reaches the white level, shape (rows, columns).
    empty
        There is nothing but noise.

    """

    image: NDArray[np.float64]
    scale: int
    floor: float
    noise: float
    clipped: NDArray[np.bool_]
    empty: bool

    @property
    def light(self) -> NDArray[np.float64]:
        """Mean of the channels, shape (rows, columns) [DN]."""
        return self.image.mean(axis=0)


def preview(mosaic: NDArray[np.uint16], *, cfa: str, black: float, white: float, longest: int) -> Preview:
    """Return a small linear picture of a mosaic.

    Parameters
    ----------
    mosaic
        Visible pixels, shape (height, width) [DN].
    cfa
        Order at its top-left pixel.
    black, white
        Levels, one for all sites; the black level may be some DN wrong [DN].
    longest
        Pixels that the longer edge has at most.

    """
    period = cell(cfa)
    cells = max(1, -(-max(mosaic.shape) // (period * longest)))
    scale = cells * period
    rows, columns = (length // scale for length in mosaic.shape)
    sites: dict[str, list[NDArray[np.float64]]] = {}
    for site, channel in enumerate(channels(cfa)):
        plane = mosaic[site // period : rows * scale : period, site % period : columns * scale : period]
        binned = plane.reshape(rows, cells, columns, cells).mean(axis=(1, 3), dtype=np.float64)
        sites.setdefault(channel[0], []).append(binned - black)
    image = np.stack([np.mean(planes, axis=0) for planes in sites.values()])
    if len(sites) > 1:
        image = image[[list(sites).index(letter) for letter in "RGB"]]
    light = image.mean(axis=0)
    noise = _noise(light)
    lowest, highest = np.percentile(light, [0.05, 99.9]) if light.size else (0.0, 0.0)
    return Preview(
        image=image,
        scale=scale,
        floor=max(3.0 * noise, _FAINT * float(highest), _UNSURE * (white - black)),
        noise=noise,
        clipped=image.max(axis=0) >= _NEARLY_WHITE * (white - black),
        empty=min(light.shape) < 8 or float(highest - lowest) <= max(_QUIET * noise, 1e-3 * (white - black)),
    )


def _noise(light: NDArray[np.float64]) -> float:
    """Return the noise of a typical pixel from second differences along rows [DN]."""
    if light.shape[1] < 3:
        return 0.0
    second = light[:, 2:] - 2.0 * light[:, 1:-1] + light[:, :-2]
    return float(np.median(np.abs(second))) / (0.6745 * 6.0**0.5)
