"""Maps of relative illumination out of files: arrays, maps of `fullwell shading fit`, libcamera's tuning files."""

import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError, why
from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import channels
from fullwell.simulate.pictures import FloatArray, interpolated

_ALSC: Final = ("rpi.alsc", "alsc")
_GRIDS: Final = {192: (12, 16), 1024: (32, 32)}
"""Rows and columns of libcamera's tables by their length."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LensMap:
    """Relative illumination on a grid.

    Parameters
    ----------
    values
        Shape (rows, columns) [1].
    rows, columns
        Where they stand, ascending: 0 at the top and left edge of the frame, 1 at the bottom and right.

    """

    values: FloatArray
    rows: FloatArray
    columns: FloatArray

    def at(self, rows: FloatArray, columns: FloatArray) -> FloatArray:
        """Return the illumination at the outer product of places, interpolated linearly [1]."""
        return interpolated(self.values, nodes=(self.rows, self.columns), at=(rows, columns))


def read_maps(path: Path, sensor: SensorParameters, *, colour_temperature: float) -> tuple[LensMap, ...]:
    """Read one map per CFA site.

    Parameters
    ----------
    path
        ``.npy``: an array of shape (rows, columns), or (sites, rows, columns), whose corners are the mosaic's corner
        pixels. ``.npz``: a map of `fullwell shading fit`. ``.json``: a libcamera tuning file with ``alsc`` tables,
        which hold what to multiply by; their reciprocals are taken, 1 at the brightest place.
    sensor
        Size and CFA.
    colour_temperature
        Of the light; libcamera's tables for the nearest one are taken [K].

    Raises
    ------
    UsageError
        Where the file cannot be read as such a map.

    """
    readers = {".npz": _measured, ".json": _libcamera}
    reader = readers.get(path.suffix.lower(), _array)
    try:
        return reader(path, sensor, colour_temperature)
    except (OSError, ValueError, KeyError, TypeError, IndexError, zipfile.BadZipFile) as error:
        raise UsageError(
            f"The shading map {path} cannot be read: {why(error)}. Give an .npy array, a map of `fullwell shading fit` "
            "(.npz), or a libcamera tuning file with alsc tables (.json)."
        ) from error


def _array(path: Path, sensor: SensorParameters, _colour_temperature: float) -> tuple[LensMap, ...]:
    table = np.asarray(np.load(path, allow_pickle=False), dtype=np.float64)
    sites = len(sensor.response)
    if table.ndim not in {2, 3} or (table.ndim == 3 and table.shape[0] != sites) or min(table.shape[-2:]) < 2:
        raise UsageError(
            f"The shading map {path} has shape {table.shape}; allowed are (rows, columns) and "
            f"({sites}, rows, columns), with two or more rows and columns."
        )
    _require_light(table, path)
    rows, columns = (
        (np.linspace(0.0, size - 1.0, count) + 0.5) / size
        for size, count in zip((sensor.height, sensor.width), table.shape[-2:], strict=True)
    )
    grids = [table] * sites if table.ndim == 2 else list(table)
    return tuple(LensMap(values=grid, rows=rows, columns=columns) for grid in grids)


def _measured(path: Path, sensor: SensorParameters, _colour_temperature: float) -> tuple[LensMap, ...]:
    """Read a map that was fitted; G1 or the one channel stands in for channels that it does not have."""
    with np.load(path, allow_pickle=False) as file:
        arrays: dict[str, NDArray[np.float64]] = {name: file[name] for name in file}
    known = [name.removesuffix(".normalized") for name in arrays if name.endswith(".normalized")]
    found: list[LensMap] = []
    for channel in channels(sensor.cfa):
        own = channel if channel in known else next(name for name in ("G1", "mono", *known) if name in known)
        height, width = arrays[f"{own}.plane_shape"]
        values = np.asarray(arrays[f"{own}.normalized"], dtype=np.float64)
        _require_light(values, path)
        rows = (arrays[f"{own}.grid_row"] + 0.5) / float(height)
        columns = (arrays[f"{own}.grid_column"] + 0.5) / float(width)
        found.append(LensMap(values=values, rows=rows, columns=columns))
    return tuple(found)


def _libcamera(path: Path, sensor: SensorParameters, colour_temperature: float) -> tuple[LensMap, ...]:
    tuning = json.loads(path.read_text(encoding="utf-8"))
    every = tuning.get("algorithms", [tuning])
    alsc = next(one[name] for one in every for name in _ALSC if name in one)
    luminance = _table(alsc["luminance_lut"])
    red, blue = (_nearest(alsc[key], colour_temperature) for key in ("calibrations_Cr", "calibrations_Cb"))
    by_channel = {"R": luminance * red, "B": luminance * blue}
    found: list[LensMap] = []
    for channel in channels(sensor.cfa):
        factors = by_channel.get(channel, luminance)
        rows, columns = ((np.arange(count) + 0.5) / count for count in factors.shape)
        found.append(LensMap(values=factors.min() / factors, rows=rows, columns=columns))
    return tuple(found)


def _nearest(calibrations: Sequence[Mapping[str, object]], colour_temperature: float) -> FloatArray:
    nearest = min(calibrations, key=lambda one: abs(float(cast("float", one["ct"])) - colour_temperature))
    return _table(cast("Sequence[float]", nearest["table"]))


def _table(values: Sequence[float]) -> FloatArray:
    if len(values) not in _GRIDS:
        raise ValueError(f"a table of {len(values)} numbers is neither 12 x 16 nor 32 x 32")
    table = np.array(values, dtype=np.float64).reshape(_GRIDS[len(values)])
    if table.min() <= 0.0:
        raise ValueError("a table holds numbers that are not above 0")
    return table


def _require_light(table: FloatArray, path: Path) -> None:
    if not np.isfinite(table).all() or table.min() < 0.0:
        raise UsageError(f"The shading map {path} holds values below 0 or none; allowed: 0 or more.")
