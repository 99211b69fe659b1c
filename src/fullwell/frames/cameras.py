"""Facts about cameras that raw files do not carry: built in for the published study's camera, else from a file."""

from pathlib import Path
from typing import Final, TypeVar

from fullwell.errors import UsageError
from fullwell.frames.series import Camera

_Fact = TypeVar("_Fact")

_BUILT_IN: Final = (
    (
        "pixel-4a",
        Camera(
            name="Pixel 4a",
            pixel_pitch_um=1.4,
            voltage_swing_v=0.45907,
            base_iso=55.0,
            focal_length_mm=4.38,
        ),
    ),
)


def camera_named(name: str | Path) -> Camera:
    """Return a camera by its built-in name or from a TOML file with a ``[camera]`` table.

    Raises
    ------
    UsageError
        Where it is neither; the sentence lists the built-in names.

    Examples
    --------
    >>> camera_named("pixel-4a").voltage_swing_v
    0.45907

    """
    for known, camera in _BUILT_IN:
        if str(name).lower() == known:
            return camera
    path = Path(name)
    if not path.is_file():
        names = ", ".join(known for known, _camera in _BUILT_IN)
        raise UsageError(f"No camera is called {name}, and no such file exists. Built in: {names}.")
    from fullwell.frames.manifest import read_camera  # noqa: PLC0415 - pydantic loads only where a file is read

    return read_camera(path)


def is_built_in(camera: Camera) -> bool:
    """Return whether these are the facts of a camera known by name."""
    return any(camera == known for _name, known in _BUILT_IN)


def combined(first: Camera, second: Camera) -> Camera:
    """Return the facts of both cameras; where both have one, the first's."""
    return Camera(
        name=_either(first.name, second.name),
        bit_depth=_either(first.bit_depth, second.bit_depth),
        cfa=_either(first.cfa, second.cfa),
        black_level=_either(first.black_level, second.black_level),
        white_level=_either(first.white_level, second.white_level),
        pixel_pitch_um=_either(first.pixel_pitch_um, second.pixel_pitch_um),
        pixel_area_um2=_either(first.pixel_area_um2, second.pixel_area_um2),
        voltage_swing_v=_either(first.voltage_swing_v, second.voltage_swing_v),
        base_iso=_either(first.base_iso, second.base_iso),
        focal_length_mm=_either(first.focal_length_mm, second.focal_length_mm),
    )


def _either(first: _Fact | None, second: _Fact | None) -> _Fact | None:
    return first if first is not None else second
