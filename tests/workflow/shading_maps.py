"""Shading maps and mosaics of a known lens, for tests."""

import numpy as np

from fullwell.fit.shading.data import ShadingData
from fullwell.raw.cfa import cell, channels
from fullwell.workflow.maps import ChannelMap, ShadingMapFile, map_grid

REACH = 150.0
"""Focal length [pixel]."""
EXPONENTS = {"R": 1.1, "G1": 1.0, "G2": 0.95, "B": 0.9, "mono": 1.0}
"""Each plane falls off in its own way, so that a plane taken for another shows."""


def lens(channel: str, rows: np.ndarray, columns: np.ndarray, *, size: tuple[int, int]) -> np.ndarray:
    """Return the shading at the outer product of mosaic rows and columns; off centre, so that a wrong turn shows."""
    y, x = (rows - 0.42 * size[0]) / REACH, (columns - 0.55 * size[1]) / REACH
    return (1.0 + y[:, None] ** 2 + x[None, :] ** 2) ** (-2.0 * EXPONENTS[channel])


def known_map(*, cfa: str = "BGGR", size: tuple[int, int] = (96, 128), orientation: int = 1) -> ShadingMapFile:
    """Return the lens as a saved map."""
    period = cell(cfa)
    found = []
    for site, channel in enumerate(channels(cfa)):
        top, left = site // period, site % period
        shape = (-(-(size[0] - top) // period), -(-(size[1] - left) // period))
        rows, columns = map_grid(shape)
        bins = (np.arange(4) * 8 + 3.5, np.arange(5) * 8 + 3.5)
        data = ShadingData(
            rows=bins[0],
            columns=bins[1],
            signal_dn=np.full((4, 5), 500.0),
            temporal_variance_dn2=np.full((4, 5), 0.1),
            fixed_variance=np.full((4, 5), 1e-6),
            plane_shape=shape,
        )
        normalized = lens(channel, period * rows + top, period * columns + left, size=size)
        found.append(
            ChannelMap(
                channel=channel,
                model="cos4",
                parameters={},
                data=data,
                grid_row=rows,
                grid_column=columns,
                normalized=normalized,
                centre=(0.42 * size[0] / period, 0.55 * size[1] / period),
                maximum_dn=500.0,
                black_level_dn=64.0,
            )
        )
    return ShadingMapFile(
        cfa=cfa,
        width=size[1],
        height=size[0],
        orientation=orientation,
        iso=100.0,
        exposure_s=0.01,
        channels=tuple(found),
    )


def light(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return a scene: texture between 0 and 1."""
    return 0.5 + 0.49 * np.sin(0.3 * rows[:, None] + 0.2) * np.cos(0.17 * columns[None, :])


def shaded_mosaic(
    *, cfa: str = "BGGR", size: tuple[int, int] = (96, 128), black: float = 64.0, full: float = 900.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the codes of a scene behind the lens, and its signal without the lens [DN]."""
    period = cell(cfa)
    codes, signal = np.empty(size, dtype=np.uint16), np.empty(size)
    for site, channel in enumerate(channels(cfa)):
        window = (slice(site // period, None, period), slice(site % period, None, period))
        rows, columns = np.arange(size[0])[window[0]], np.arange(size[1])[window[1]]
        signal[window] = full * light(rows, columns)
        codes[window] = np.rint(black + signal[window] * lens(channel, rows, columns, size=size))
    return codes, signal
