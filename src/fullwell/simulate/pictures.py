"""Pictures as scenes: read as linear light, and any table stretched over the frame."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError, why

FloatArray = NDArray[np.float64]

SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".npy")


def read_light(path: Path) -> FloatArray:
    """Read a picture as linear light relative to white.

    Parameters
    ----------
    path
        A picture in sRGB, decoded by its curve (IEC 61966-2-1); or an ``.npy`` array of linear light, shape
        (rows, columns) or (rows, columns, 3), zero or more.

    Returns
    -------
    ndarray
        Shape (3, rows, columns) [1].

    Raises
    ------
    UsageError
        Where it cannot be read as one.

    """
    try:
        light = np.load(path, allow_pickle=False) if path.suffix.lower() == ".npy" else _decoded(path)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"The picture {path} cannot be read: {why(error)}. Give a PNG, JPEG, TIFF or .npy file."
        ) from error
    light = np.asarray(light, dtype=np.float64)
    light = light[:, :, None].repeat(3, axis=2) if light.ndim == 2 else light
    if light.ndim != 3 or light.shape[2] != 3 or min(light.shape[:2]) < 2 or not np.isfinite(light).all():
        raise UsageError(
            f"The picture {path} has shape {light.shape}; allowed are (rows, columns) and (rows, columns, 3)."
        )
    if light.min() < 0.0:
        raise UsageError(f"The picture {path} holds {light.min():g}; allowed: light of 0 or more.")
    return np.ascontiguousarray(light.transpose(2, 0, 1))


def _decoded(path: Path) -> FloatArray:
    from PIL import Image  # noqa: PLC0415 - loads when used

    with Image.open(path) as opened:
        shown = np.asarray(opened.convert("RGB"), dtype=np.float64) / 255.0
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def stretched(table: FloatArray, rows: FloatArray, columns: FloatArray) -> FloatArray:
    """Interpolate a picture linearly at the outer product of places from 0 to 1, the edges of the frame."""
    nodes = tuple((np.arange(size) + 0.5) / size for size in table.shape)
    return interpolated(table, nodes=(nodes[0], nodes[1]), at=(rows, columns))


def interpolated(
    table: FloatArray, *, nodes: tuple[FloatArray, FloatArray], at: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Interpolate a table linearly at an outer product; beyond its nodes the outermost values hold.

    Parameters
    ----------
    table
        Shape (rows, columns), two or more of each.
    nodes
        Where its rows and columns stand, ascending.
    at
        Rows and columns that are asked for, in the same unit.

    """
    y, x = (np.interp(wanted, own, np.arange(own.size)) for wanted, own in zip(at, nodes, strict=True))
    top = np.minimum(y.astype(np.intp), table.shape[0] - 2)
    left = np.minimum(x.astype(np.intp), table.shape[1] - 2)
    down, across = (y - top)[:, None], (x - left)[None, :]
    upper = table[np.ix_(top, left)] * (1 - across) + table[np.ix_(top, left + 1)] * across
    lower = table[np.ix_(top + 1, left)] * (1 - across) + table[np.ix_(top + 1, left + 1)] * across
    return upper * (1 - down) + lower * down
