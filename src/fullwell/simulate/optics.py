"""The lens: how much of the light reaches each pixel.

Natural vignetting is cos^4 of the angle off the axis, raised to an exponent per channel where colours fall off
differently; a map file takes its place where one was measured. Flare is an even veil on top of everything.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell
from fullwell.simulate.sensors import by_channel
from fullwell.simulate.shot import FloatArray, Shot
from fullwell.simulate.tables import CameraTable, LensTable


def illumination(light: FloatArray, shot: Shot) -> FloatArray:
    """Return the light at each pixel of the tile, its site's response applied [1].

    Parameters
    ----------
    light
        Light of the scene [1].
    shot
        What is taken.

    """
    camera = shot.camera
    seen = light * camera.lens[shot.tile.window]
    return seen + camera.flare * shot.by_site(shot.sensor.response) if camera.flare else seen


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """A lens.

    Parameters
    ----------
    shading
        ``none``, ``cos4``, or the path of a map.
    exponents
        Power of the fall-off per CFA site, row-major [1].
    focal_length_mm
        Distance of the exit pupil [mm].
    flare
        Stray light as a fraction of the largest signal [1].

    """

    shading: str
    exponents: tuple[float, ...]
    focal_length_mm: float
    flare: float

    def map_for(self, sensor: SensorParameters) -> NDArray[np.float32]:
        """Return relative illumination times response of each pixel, shape (height, width) [1]."""
        if self.shading == "none":
            return even(sensor)
        if self.shading == "cos4":
            return cos4(sensor, focal_length_mm=self.focal_length_mm, exponents=self.exponents)
        return mapped(sensor, Path(self.shading))


def lens_of(table: LensTable, camera: CameraTable, *, folder: Path) -> Lens:
    """Return the lens that a config describes; the path of a map is relative to ``folder``."""
    return Lens(
        shading=table.shading if table.shading in {"none", "cos4"} else str(folder / table.shading),
        exponents=by_channel(camera, table.shading_exponent.model_dump()),
        focal_length_mm=table.focal_length_mm,
        flare=table.flare,
    )


def cos4(sensor: SensorParameters, *, focal_length_mm: float, exponents: tuple[float, ...]) -> NDArray[np.float32]:
    """Return the relative illumination (1 + r^2/f^2)^-2 times the response of each pixel.

    Parameters
    ----------
    sensor
        Size, pitch, CFA and response.
    focal_length_mm
        Distance of the exit pupil [mm].
    exponents
        Per CFA site, row-major: the power the fall-off is raised to [1].

    Returns
    -------
    ndarray
        Shape (height, width), float32, the response at the optical centre [1].

    """
    reach = focal_length_mm * 1000.0 / sensor.pixel_pitch_um
    y2 = ((np.arange(sensor.height) - (sensor.height - 1) / 2.0) / reach) ** 2
    x2 = ((np.arange(sensor.width) - (sensor.width - 1) / 2.0) / reach) ** 2
    out = np.empty((sensor.height, sensor.width), dtype=np.float32)
    period = cell(sensor.cfa)
    for site, (response, exponent) in enumerate(zip(sensor.response, exponents, strict=True)):
        rows, columns = slice(site // period, None, period), slice(site % period, None, period)
        out[rows, columns] = response * (1.0 + y2[rows, None] + x2[None, columns]) ** (-2.0 * exponent)
    return out


def even(sensor: SensorParameters) -> NDArray[np.float32]:
    """Return the response of each pixel behind a lens that shades nothing, shape (height, width), float32 [1]."""
    return cos4(sensor, focal_length_mm=1.0, exponents=(0.0,) * len(sensor.response))


def mapped(sensor: SensorParameters, path: Path) -> NDArray[np.float32]:
    """Return a map file's relative illumination times the response of each pixel.

    Parameters
    ----------
    sensor
        Size, CFA and response.
    path
        An ``.npy`` array of shape (rows, columns), or (sites, rows, columns) for one map per CFA site; its corners
        are the mosaic's corner pixels, and what lies between is interpolated linearly.

    Returns
    -------
    ndarray
        Shape (height, width), float32 [1].

    Raises
    ------
    UsageError
        Where the file cannot be read as such an array.

    """
    try:
        table = np.asarray(np.load(path, allow_pickle=False), dtype=np.float64)
    except (OSError, ValueError) as error:
        raise UsageError(f"The shading map {path} cannot be read: {error}. Give an .npy array.") from error
    sites = len(sensor.response)
    if table.ndim not in {2, 3} or (table.ndim == 3 and table.shape[0] != sites) or min(table.shape[-2:]) < 2:
        raise UsageError(
            f"The shading map {path} has shape {table.shape}; allowed are (rows, columns) and "
            f"({sites}, rows, columns), with two or more rows and columns."
        )
    out = np.empty((sensor.height, sensor.width), dtype=np.float32)
    period = cell(sensor.cfa)
    for site, response in enumerate(sensor.response):
        rows = np.arange(site // period, sensor.height, period) / max(sensor.height - 1, 1)
        columns = np.arange(site % period, sensor.width, period) / max(sensor.width - 1, 1)
        grid = table if table.ndim == 2 else table[site]
        out[site // period :: period, site % period :: period] = response * _bilinear(grid, rows, columns)
    return out


def _bilinear(table: FloatArray, rows: FloatArray, columns: FloatArray) -> FloatArray:
    """Interpolate a table at the outer product of relative places from 0 to 1."""
    y, x = rows * (table.shape[0] - 1), columns * (table.shape[1] - 1)
    top = np.minimum(y.astype(np.intp), table.shape[0] - 2)
    left = np.minimum(x.astype(np.intp), table.shape[1] - 2)
    down, across = (y - top)[:, None], (x - left)[None, :]
    upper = table[np.ix_(top, left)] * (1 - across) + table[np.ix_(top, left + 1)] * across
    lower = table[np.ix_(top + 1, left)] * (1 - across) + table[np.ix_(top + 1, left + 1)] * across
    return upper * (1 - down) + lower * down
