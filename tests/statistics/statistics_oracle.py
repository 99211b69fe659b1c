"""Statistics of a stack of frames by brute force, for comparison."""

import itertools

import numpy as np
from numpy.typing import NDArray


def planes_of(frames: NDArray[np.uint16], cell: int) -> list[NDArray[np.float64]]:
    return [frames[:, site // cell :: cell, site % cell :: cell].astype(np.float64) for site in range(cell**2)]


def mean_squares(x: NDArray[np.float64]) -> dict[str, float]:
    """Three-way layout by its definition: effects by subtraction, sums of squares over the whole array."""
    frames, rows, columns = x.shape
    t, v, h = x.mean((1, 2), keepdims=True), x.mean((0, 2), keepdims=True), x.mean((0, 1), keepdims=True)
    tv, th, vh = x.mean(2, keepdims=True), x.mean(1, keepdims=True), x.mean(0, keepdims=True)
    mean = x.mean()
    effects = {
        "t": (t - mean, frames - 1),
        "v": (v - mean, rows - 1),
        "h": (h - mean, columns - 1),
        "tv": (tv - t - v + mean, (frames - 1) * (rows - 1)),
        "th": (th - t - h + mean, (frames - 1) * (columns - 1)),
        "vh": (vh - v - h + mean, (rows - 1) * (columns - 1)),
        "tvh": (x - tv - th - vh + t + v + h - mean, (frames - 1) * (rows - 1) * (columns - 1)),
    }
    return {name: float((np.broadcast_to(e, x.shape) ** 2).sum() / dof) for name, (e, dof) in effects.items() if dof}


def tile_variances(tile: NDArray[np.float64]) -> tuple[float, float]:
    """Temporal variance with each frame's mean removed, and spatial residual about a quadratic by least squares."""
    frames, rows, columns = tile.shape
    n = rows * columns
    flicker_free = tile - tile.mean((1, 2), keepdims=True)
    temporal = ((flicker_free - flicker_free.mean(0)) ** 2).sum() / ((n - 1) * (frames - 1)) if frames > 1 else np.nan
    v, u = (axis.ravel() for axis in np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j])
    design = np.stack([np.ones(n), u, v, u * u, u * v, v * v], axis=1)
    mean = tile.mean(0).ravel()
    if rows < 3 or columns < 3 or n <= 6:
        return float(temporal), float("nan")
    fitted = design @ np.linalg.lstsq(design, mean, rcond=None)[0]
    return float(temporal), float(((mean - fitted) ** 2).sum() / (n - 6))


def legacy(x: NDArray[np.float64]) -> tuple[float, float]:
    """Pair variance and residual variance of a burst; x has shape (frames, pixels...)."""
    pairs = [np.var(a - b, ddof=1) for a, b in itertools.combinations(x, 2)]
    residuals = [np.var(frame - x.mean(0), ddof=1) for frame in x]
    return float(np.mean(pairs)), float(np.mean(residuals))
