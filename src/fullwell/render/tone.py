"""From codes to light and from light to the eye: levels, white balance, the sRGB curve."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.cfa import MONO, cell

FloatImage = NDArray[np.float32]

_NEARLY_WHITE: Final = 0.95


def relative(
    mosaic: NDArray[np.uint16], *, cfa: str, black_level: Sequence[float], white_level: Sequence[float]
) -> FloatImage:
    """Return codes on a scale from black 0 to white 1, unclipped at both ends.

    Parameters
    ----------
    mosaic
        Codes, shape (height, width) [DN].
    cfa
        Order at the top-left pixel, or ``mono``.
    black_level, white_level
        Per CFA site, row-major [DN].

    """
    period = cell(cfa)
    out = np.empty(mosaic.shape, dtype=np.float32)
    for site, (black, white) in enumerate(zip(black_level, white_level, strict=True)):
        window = (slice(site // period, None, period), slice(site % period, None, period))
        out[window] = (mosaic[window] - np.float32(black)) / np.float32(white - black)
    return out


def grey_world(light: FloatImage, *, cfa: str) -> tuple[float, float, float]:
    """Return what a grey world looks like to the camera: mean red, green and blue of what is neither black nor white.

    Parameters
    ----------
    light
        Mosaic from black 0 to white 1, shape (height, width).
    cfa
        Order at the top-left pixel, or ``mono``.

    """
    if cfa == MONO:
        return (1.0, 1.0, 1.0)
    means = {"R": [0.0, 0.0], "G": [0.0, 0.0], "B": [0.0, 0.0]}
    for site, letter in enumerate(cfa):
        plane = light[site // 2 :: 2, site % 2 :: 2]
        used = plane[(plane > 0.0) & (plane < _NEARLY_WHITE)]
        means[letter][0] += float(used.sum(dtype=np.float64))
        means[letter][1] += used.size
    red, green, blue = (total / count if count and total > 0.0 else 0.0 for total, count in means.values())
    return (red, green, blue) if min(red, green, blue) > 0.0 else (1.0, 1.0, 1.0)


def white_balanced(rgb: FloatImage, *, neutral: Sequence[float]) -> FloatImage:
    """Return a picture in which a neutral object is grey; no colour is made darker.

    Parameters
    ----------
    rgb
        Linear, shape (height, width, 3) [1].
    neutral
        White as the camera sees it: red, green, blue (DNG tag AsShotNeutral).

    """
    factors = np.asarray([max(neutral) / one for one in neutral], dtype=np.float32)
    return rgb * factors


def srgb_curve(light: FloatImage) -> FloatImage:
    """Return display values of linear light, both from 0 to 1; what lies beyond is clipped (IEC 61966-2-1).

    Examples
    --------
    >>> [f"{shown:.3f}" for shown in srgb_curve(np.array([-1.0, 0.0, 0.18, 1.0, 2.0], dtype=np.float32))]
    ['0.000', '0.000', '0.461', '1.000', '1.000']

    """
    clipped = np.clip(light, np.float32(0.0), np.float32(1.0))
    bent = np.float32(1.055) * clipped ** np.float32(1.0 / 2.4) - np.float32(0.055)
    return np.where(clipped <= np.float32(0.0031308), np.float32(12.92) * clipped, bent)
