"""Sidecars that Fullwell writes beside frames whose format has no tags for levels, colours or exposure."""

import json
from collections.abc import Sequence
from pathlib import Path

from fullwell.frames.sidecar import PIXEL_FORMATS


def sidecar_text(
    *,
    cfa: str,
    bit_depth: int,
    width: int,
    height: int,
    black_level: Sequence[float] | None,
    white_level: Sequence[float] | None,
    iso: float | None = None,
    exposure_s: float | None = None,
    temperature_c: float | None = None,
    make: str | None = None,
    model: str | None = None,
    noise_profile: Sequence[Sequence[float]] = (),
    as_shot_neutral: Sequence[float] = (),
) -> str:
    """Return a sidecar, a JSON object by GenICam names, which `read_sidecar` understands.

    Parameters
    ----------
    cfa
        Order at the first pixel, or ``mono``.
    bit_depth
        Of the codes, whatever container they are in [bit].
    width, height
        [pixel].
    black_level, white_level
        One number, or one per CFA site, row by row; None where unknown [DN].
    iso, exposure_s, temperature_c
        None where unknown [-, s, deg C].
    make, model, noise_profile, as_shot_neutral
        As in `RawHeader`; what is empty is left out.

    """
    facts = {
        "PixelFormat": f"{PIXEL_FORMATS[cfa]}{bit_depth}",
        "Width": width,
        "Height": height,
        "BlackLevel": _levels(black_level),
        "WhiteLevel": _levels(white_level),
        "ISO": iso,
        "ExposureTime": None if exposure_s is None else exposure_s * 1e6,
        "DeviceTemperature": temperature_c,
        "DeviceVendorName": make,
        "DeviceModelName": model,
        "NoiseProfile": [list(plane) for plane in noise_profile] or None,
        "AsShotNeutral": list(as_shot_neutral) or None,
    }
    return json.dumps({name: value for name, value in facts.items() if value is not None}, indent=1) + "\n"


def sidecar_path(frame: Path) -> Path:
    """Return where the sidecar of a frame belongs."""
    return frame.with_suffix(".json")


def _levels(values: Sequence[float] | None) -> float | list[float] | None:
    """Return one number where all are alike."""
    if not values:
        return None
    return values[0] if len(set(values)) == 1 else list(values)
