"""How well the neighbours of a pixel foretell it: the measure by which geometries of a file are compared."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.raw.headerless import unpacked
from fullwell.raw.headerless_format import HeaderlessFormat

_BANDS: Final = 48
_PIECE: Final = 64
"""Residuals are as large as they are over so many pixels: a scene has quiet and busy parts."""
_ALIKE: Final = 0.02
"""Neighbours of another colour foretell a pixel worse by more than this [bit]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Predictability:
    """What neighbours leave to be told of a pixel.

    Parameters
    ----------
    bits
        After the neighbours that foretell best [bit].
    alike
        Whether direct neighbours foretell better than the next but one: there is no colour-filter array.

    """

    bits: float
    alike: bool


def bits_to_tell(stated: HeaderlessFormat, data: memoryview) -> Predictability:
    """Return how many bits of a pixel the one to its left and the one above do not tell.

    The differences are taken for Laplace distributed, of a width b that changes over the picture, whose entropy is
    log2(2 e b); bands of rows all over the frame are looked at.

    Parameters
    ----------
    stated
        The geometry to try.
    data
        The whole file, which must hold it.

    """
    tops = np.unique(np.linspace(0, max(stated.height - 3, 0), min(_BANDS, stated.height)).astype(int))
    direct: list[float] = []
    second: list[float] = []
    for top in tops:
        rows = min(3, stated.height - int(top))
        band = unpacked(
            replace(stated, height=rows, offset=stated.offset + int(top) * stated.stride, trailer=0), data
        ).astype(np.int32)
        direct.append(_bits(2 * band[1:, 1:] - band[1:, :-1] - band[:-1, 1:]))
        if rows == 3:
            second.append(_bits(2 * band[2:, 2:] - band[2:, :-2] - band[:-2, 2:]))
    one, two = float(np.mean(direct)), float(np.mean(second)) if second else math.inf
    return Predictability(bits=min(one, two), alike=bool(second) and one < two - _ALIKE)


def _bits(doubled: NDArray[np.int32]) -> float:
    """Return the entropy of residuals that are given twofold [bit]."""
    size = np.abs(doubled).ravel() / 2.0
    pieces = size[: size.size // _PIECE * _PIECE].reshape(-1, _PIECE) if size.size >= _PIECE else size[None]
    return float(np.log2(1.0 + 2.0 * math.e * pieces.mean(axis=1)).mean())


def greens_of(mosaic: NDArray[np.uint16]) -> tuple[str, str] | None:
    """Return the two CFA orders whose green pixels lie where two pixels of the cell are alike; None where none are.

    Parameters
    ----------
    mosaic
        Codes, shape (height, width) [DN].

    """
    height, width = (side // 2 * 2 for side in mosaic.shape)
    step = max(1, height // 512) * 2
    cells = [mosaic[row:height:step, column:width:2].astype(np.float64) for row in (0, 1) for column in (0, 1)]
    main, other = (float(np.abs(cells[a] - cells[b]).mean()) for a, b in ((0, 3), (1, 2)))
    if abs(main - other) < 0.1 * max(main, other):
        return None
    return ("GRBG", "GBRG") if main < other else ("RGGB", "BGGR")
