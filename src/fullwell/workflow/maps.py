"""Maps on disk: shading maps and maps per pixel as ``.npz``, each with a ``.json`` beside it that says what is in it.

The same arrays give the same bytes: no time of writing, no compression that is left to chance. Nothing is pickled, so
that a map from anywhere can be opened.
"""

import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.fit.shading.data import ShadingData
from fullwell.raw.cfa import channels
from fullwell.render.interpolation import interpolated
from fullwell.units import DN, DN2

SCHEMA: Final = "fullwell-map/1"
GRID_ROWS: Final = 64
GRID_COLUMNS: Final = 84
"""The most points that a shading map is evaluated at."""

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
_REGULAR: Final = ("fixed_variance",)
"""Arrays of bins with few distinct values: packing pays."""
_BINNED: Final = (
    ("rows", "pixel", "centres of the bins in the plane, counted from 0"),
    ("columns", "pixel", "centres of the bins in the plane, counted from 0"),
    ("signal_dn", DN, "mean of the bin, black subtracted; NaN where it is left out"),
    ("temporal_variance_dn2", DN2, "temporal variance of the bin's mean"),
    ("fixed_variance", "1", "relative variance of the bin's mean from PRNU"),
)
_GRIDDED: Final = (
    ("grid_row", "pixel", "rows of the plane at which the map is evaluated"),
    ("grid_column", "pixel", "columns of the plane at which the map is evaluated"),
    ("normalized", "1", "relative illumination of the chosen model, 1 at its centre"),
)
_PARAMETER: Final = "model."
_WHERE: Final = "as the model's to_arrays() gives it"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NamedArray:
    """An array with its unit, for a file that others read.

    Parameters
    ----------
    values
        Any shape.
    unit
        As rows of results have it.
    description
        What the numbers are.

    """

    values: NDArray[Any]
    unit: str
    description: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelMap:
    """The shading of one CFA plane in one burst.

    Parameters
    ----------
    channel
        ``R``, ``G1``, ``G2``, ``B`` or ``mono``.
    model
        Name of the chosen model.
    parameters
        The model as plain arrays (``ShadingModel.to_arrays``).
    data
        The bins the model was fitted to.
    grid_row, grid_column
        Where the map is evaluated, ascending, shapes (V,) and (H,), in pixels of the plane; see `map_grid`.
    normalized
        Relative illumination, shape (V, H), 1 at ``centre`` [1].
    centre
        Row and column of the smooth surface's maximum, in pixels of the plane.
    maximum_dn
        Its value there [DN].
    black_level_dn
        What was subtracted [DN].

    """

    channel: str
    model: str
    parameters: Mapping[str, NDArray[Any]]
    data: ShadingData
    grid_row: NDArray[np.float64]
    grid_column: NDArray[np.float64]
    normalized: NDArray[np.float64]
    centre: tuple[float, float]
    maximum_dn: float
    black_level_dn: float

    def at(self, rows: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the map at the outer product of rows (R,) and columns (C,) of the plane, shape (R, C) [1]."""
        return interpolated(self.normalized, rows=self.grid_row, columns=self.grid_column, at=(rows, columns))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShadingMapFile:
    """The shading of one burst, every plane of it.

    Parameters
    ----------
    cfa, width, height, orientation
        Of the flats: order at the visible top-left pixel, size of the visible mosaic [pixel], TIFF tag Orientation.
    iso, exposure_s
        Of the burst; ``iso`` is None where nothing says it [1, s].
    camera
        Its name, where known.
    channels
        One per CFA site, row-major.

    """

    cfa: str
    width: int
    height: int
    orientation: int
    iso: float | None
    exposure_s: float
    channels: tuple[ChannelMap, ...]
    camera: str | None = None

    @property
    def stem(self) -> str:
        """Name of its files without a suffix."""
        return shading_stem(iso=self.iso, exposure_s=self.exposure_s)


def shading_stem(*, iso: float | None, exposure_s: float) -> str:
    """Return the name of a burst's shading map, without a suffix; names sort by exposure.

    Examples
    --------
    >>> shading_stem(iso=55.0, exposure_s=0.0004)
    'shading_iso55_exp000000400us'

    """
    microseconds = f"{exposure_s * 1e6:013.3f}".removesuffix(".000").zfill(9)
    return f"shading_iso{'unknown' if iso is None else f'{iso:g}'}_exp{microseconds}us"


def map_grid(plane_shape: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows and columns of a plane at which its map is evaluated: evenly spaced, both edges among them."""
    points = (min(plane_shape[0], GRID_ROWS), min(plane_shape[1], GRID_COLUMNS))
    rows, columns = (np.linspace(0.0, length - 1.0, n) for length, n in zip(plane_shape, points, strict=True))
    return rows, columns


def save_shading_map(folder: Path, shading: ShadingMapFile) -> Path:
    """Write a shading map as ``shading_iso<iso>_exp<exposure>.npz`` with its ``.json``.

    Parameters
    ----------
    folder
        An existing folder.
    shading
        The map. Data of bins are stored as float32: they carry noise far above its rounding.

    Returns
    -------
    Path
        The ``.npz``.

    """
    arrays = {name: _scalar(value, unit, text) for name, value, unit, text in _scalars(shading)}
    for one in shading.channels:
        arrays |= {f"{one.channel}.{name}": array for name, array in _channel_arrays(one).items()}
    path = folder / f"{shading.stem}.npz"
    _save(path, arrays, kind="shading", packed=lambda name: name.rpartition(".")[2] in _REGULAR)
    return path


def load_shading_map(path: Path) -> ShadingMapFile:
    """Read a shading map.

    Raises
    ------
    UsageError
        The file is none, or damaged.

    """
    wish = "Give a shading map as `fullwell shading fit` writes it (maps/shading_*.npz)."
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as opened:
            arrays = {name: np.asarray(opened[name]) for name in opened.files}
        return _shading_from(arrays)
    except FileNotFoundError as error:
        raise UsageError(f"{path} does not exist. {wish}") from error
    except (KeyError, ValueError, TypeError, EOFError, IndexError, zipfile.BadZipFile) as error:
        raise UsageError(f"{path} is no shading map of ours, or damaged. {wish}") from error


def save_pixel_maps(path: Path, arrays: Mapping[str, NamedArray], *, about: Mapping[str, object] | None = None) -> Path:
    """Write maps per pixel as an uncompressed float32 ``.npz`` with its ``.json``.

    Parameters
    ----------
    path
        The ``.npz`` to write.
    arrays
        Maps by name.
    about
        What else the ``.json`` should say: ISO, channel, exposures ...

    Returns
    -------
    Path
        The ``.npz``.

    """
    narrow = {
        name: NamedArray(values=one.values.astype(np.float32, copy=False), unit=one.unit, description=one.description)
        for name, one in arrays.items()
    }
    _save(path, narrow, kind="pixels", packed=lambda _name: False, about=about)
    return path


def _scalars(shading: ShadingMapFile) -> Sequence[tuple[str, object, str, str]]:
    return (
        ("cfa", shading.cfa, "", "order at the visible top-left pixel"),
        ("width", shading.width, "pixel", "width of the visible mosaic"),
        ("height", shading.height, "pixel", "height of the visible mosaic"),
        ("orientation", shading.orientation, "", "TIFF tag Orientation of the flats"),
        ("iso", _or_nan(shading.iso), "1", "ISO speed; NaN where unknown"),
        ("exposure_s", shading.exposure_s, "s", "exposure"),
        ("camera", shading.camera or "", "", "the camera, where known"),
    )


def _scalar(value: object, unit: str, text: str) -> NamedArray:
    return NamedArray(values=np.asarray(value), unit=unit, description=text)


def _channel_arrays(one: ChannelMap) -> dict[str, NamedArray]:
    arrays = {
        "model": _scalar(one.model, "", "name of the chosen model"),
        "centre": _scalar(one.centre, "pixel", "row and column of the maximum, in the plane"),
        "maximum_dn": _scalar(one.maximum_dn, DN, "the smooth surface at its centre"),
        "black_level_dn": _scalar(one.black_level_dn, DN, "black level that was subtracted"),
        "plane_shape": _scalar(one.data.plane_shape, "pixel", "rows and columns of the plane"),
        "pitch_um": _scalar(_or_nan(one.data.pitch_um), "um", "distance of two pixels of the plane; NaN: unknown"),
        "focal_length_mm": _scalar(_or_nan(one.data.focal_length_mm), "mm", "stated focal length; NaN: unknown"),
    }
    for source, names, dtype in ((one.data, _BINNED, np.float32), (one, _GRIDDED, np.float64)):
        for name, unit, text in names:
            values = np.asarray(getattr(source, name), dtype=dtype)
            arrays[name] = NamedArray(values=values, unit=unit, description=text)
    for name, values in one.parameters.items():
        arrays[f"{_PARAMETER}{name}"] = NamedArray(values=np.asarray(values), unit="", description=_WHERE)
    return arrays


def _shading_from(arrays: Mapping[str, NDArray[Any]]) -> ShadingMapFile:
    cfa = str(arrays["cfa"])
    return ShadingMapFile(
        cfa=cfa,
        width=int(arrays["width"]),
        height=int(arrays["height"]),
        orientation=int(arrays["orientation"]),
        iso=_or_none(arrays["iso"]),
        exposure_s=float(arrays["exposure_s"]),
        camera=str(arrays["camera"]) or None,
        channels=tuple(_channel_from(channel, arrays) for channel in channels(cfa)),
    )


def _channel_from(channel: str, arrays: Mapping[str, NDArray[Any]]) -> ChannelMap:
    own = {name.removeprefix(f"{channel}."): one for name, one in arrays.items() if name.startswith(f"{channel}.")}
    row, column = (float(place) for place in own["centre"])
    down, across = (int(length) for length in own["plane_shape"])
    data = ShadingData(
        plane_shape=(down, across),
        pitch_um=_or_none(own["pitch_um"]),
        focal_length_mm=_or_none(own["focal_length_mm"]),
        **{name: own[name].astype(np.float64) for name, _unit, _text in _BINNED},
    )
    return ChannelMap(
        channel=channel,
        model=str(own["model"]),
        parameters={name.removeprefix(_PARAMETER): one for name, one in own.items() if name.startswith(_PARAMETER)},
        centre=(row, column),
        maximum_dn=float(own["maximum_dn"]),
        black_level_dn=float(own["black_level_dn"]),
        data=data,
        **{name: own[name].astype(np.float64) for name, _unit, _text in _GRIDDED},
    )


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else value


def _or_none(value: NDArray[Any]) -> float | None:
    return None if np.isnan(value) else float(value)


def _save(
    path: Path,
    arrays: Mapping[str, NamedArray],
    *,
    kind: str,
    packed: Callable[[str], bool],
    about: Mapping[str, object] | None = None,
) -> None:
    """Write arrays and what is to be said about them."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, one in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=_EPOCH)
            entry.create_system = 3  # the same bytes on every system
            entry.compress_type = zipfile.ZIP_DEFLATED if packed(name) else zipfile.ZIP_STORED
            with archive.open(entry, "w", force_zip64=True) as file:
                values = np.asarray(one.values, order="C")
                header = np.lib.format.header_data_from_array_1_0(values)
                np.lib.format.write_array_header_1_0(file, header)
                file.write(values.reshape(-1).view(np.uint8).data)
    document = {
        "schema": SCHEMA,
        "kind": kind,
        **(about or {}),
        "arrays": [
            {
                "name": name,
                "shape": list(one.values.shape),
                "dtype": "str" if one.values.dtype.kind == "U" else one.values.dtype.name,
                "unit": one.unit,
                "description": one.description,
            }
            for name, one in arrays.items()
        ],
    }
    text = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
    path.with_suffix(".json").write_text(text, encoding="utf-8", newline="\n")
