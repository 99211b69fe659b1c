"""Small raw files for studies: written by tifffile, an independent writer."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
import tifffile

MakeFrame = Callable[..., Path]


def _tiff(path: Path, *, height: int = 8, width: int = 12, value: int = 100, dtype: str = "uint16") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    tifffile.imwrite(path, np.full((height, width), value, dtype=dtype), photometric="minisblack", metadata=None)
    return path


@pytest.fixture
def make_tiff() -> MakeFrame:
    """Return a function that writes a single-channel TIFF, with a JSON sidecar if one is given."""

    def make(path: Path, *, sidecar: Mapping[str, object] | None = None, height: int = 8, width: int = 12) -> Path:
        _tiff(path, height=height, width=width)
        if sidecar is not None:
            path.with_suffix(".json").write_text(json.dumps(sidecar), encoding="utf-8")
        return path

    return make


@pytest.fixture
def make_dng() -> MakeFrame:
    """Return a function that writes an uncompressed DNG with CFA, levels, ISO and exposure."""

    def make(
        path: Path,
        *,
        iso: int | None = 100,
        exposure_us: int | None = 10_000,
        cfa: str = "RGGB",
        black: int = 64,
        white: int = 1023,
        height: int = 8,
        width: int = 12,
        serial: str | None = None,
    ) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        pattern = bytes("RGB".index(letter) for letter in cfa)
        tags: list[tuple[int, int, int, object, bool]] = [
            (33421, 3, 2, (2, 2), True),
            (33422, 1, 4, pattern, True),
            (50706, 1, 4, bytes((1, 4, 0, 0)), True),
            (50708, 2, 9, "Test cam", True),
            (50714, 4, 1, black, True),
            (50717, 4, 1, white, True),
        ]
        if serial is not None:
            tags.append((50735, 2, 0, serial, True))
        if exposure_us is not None:
            tags.append((33434, 5, 1, (exposure_us, 1_000_000), True))
        if iso is not None:
            tags.append((34855, 3, 1, iso, True))
        mosaic = np.full((height, width), 100, dtype=np.uint16)
        tifffile.imwrite(path, mosaic, photometric=32803, metadata=None, extratags=tags)
        return path

    return make
