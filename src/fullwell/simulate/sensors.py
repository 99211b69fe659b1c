"""From the tables of a config to the parameters of a sensor, at every ISO."""

from collections.abc import Mapping
from typing import cast

from fullwell.model.sensor import SensorParameters
from fullwell.raw.cfa import cell, channels
from fullwell.simulate.tables import CameraTable

_PERCENT = 100.0


def base_sensor(camera: CameraTable) -> SensorParameters:
    """Return what ``[camera]`` says, per CFA site, with fractions for percentages."""
    return SensorParameters(
        width=camera.width,
        height=camera.height,
        cfa=camera.cfa,
        bit_depth=camera.bit_depth,
        black_level=black_levels(camera),
        white_level=white_level(camera),
        base_iso=float(camera.base_iso),
        system_gain=camera.system_gain,
        full_well=camera.full_well,
        response=by_channel(camera, camera.channel_response.model_dump()),
        read_noise=camera.read_noise,
        read_noise_row=camera.read_noise_row,
        read_noise_column=camera.read_noise_column,
        read_noise_frame=camera.read_noise_frame,
        read_noise_post=camera.read_noise_post,
        rts_pixels=camera.rts_pixels,
        rts_amplitude=camera.rts_amplitude,
        dark_current=camera.dark_current,
        dark_current_spread=camera.dark_current_spread,
        dark_current_doubling_c=camera.dark_current_doubling_c,
        dark_current_reference_c=camera.dark_current_reference_c,
        hot_pixels=camera.hot_pixels,
        hot_pixel_current=camera.hot_pixel_current,
        dsnu=camera.dsnu,
        dsnu_row=camera.dsnu_row,
        dsnu_column=camera.dsnu_column,
        prnu=camera.prnu / _PERCENT,
        prnu_row=camera.prnu_row / _PERCENT,
        prnu_column=camera.prnu_column / _PERCENT,
        nonlinearity=camera.nonlinearity / _PERCENT,
        blooming=camera.blooming,
        brighter_fatter=camera.brighter_fatter,
        dual_conversion_ratio=camera.dual_conversion_ratio,
        pixel_pitch_um=camera.pixel_pitch_um,
    )


def sensor_at(camera: CameraTable, iso: float) -> SensorParameters:
    """Return the parameters at an ISO; what ``[[camera.at_iso]]`` says of it stands for itself."""
    said = next((table for table in camera.at_iso if table.iso == iso), None)
    if said is None:
        return base_sensor(camera)
    changes = said.model_dump(exclude={"iso"}, exclude_none=True)
    if said.system_gain is not None:
        changes["system_gain"] = said.system_gain * camera.base_iso / iso
    return base_sensor(camera.model_copy(update=changes))


def black_levels(camera: CameraTable) -> tuple[float, ...]:
    """Return the black level of every CFA site, as many as are given [DN]."""
    black = camera.black_level
    return tuple(black) if isinstance(black, list) else (float(black),) * cell(camera.cfa) ** 2


def white_level(camera: CameraTable) -> int:
    """Return the white level: what the bits hold where nobody gave one [DN]."""
    return camera.white_level or 2**camera.bit_depth - 1


def by_channel(camera: CameraTable, values: Mapping[str, object]) -> tuple[float, ...]:
    """Return the value of every CFA site, row-major."""
    return tuple(cast("float", values[channel]) for channel in channels(camera.cfa))
