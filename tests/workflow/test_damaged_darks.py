"""Darks that turn out to be damaged while they are decoded: the figures are those of a study without them."""

from pathlib import Path

import numpy as np
import pytest

from fullwell.figures.results import Row
from fullwell.raw.write import write_dng
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

HEIGHT, WIDTH, FRAMES = 64, 96, 3
FLATS = (0.05, 0.10, 0.15, 0.18)
UNLIT = (0.0001, 0.20, 0.22, 0.25, 1.0)


def write_study(root: Path, *, damaged: tuple[float, ...] = (), left_out: tuple[float, ...] = ()) -> Path:
    """Write a study whose dark signal differs from pixel to pixel; of damaged series one frame survives."""
    rng = np.random.default_rng(1)
    prnu = 1.0 + 0.01 * rng.standard_normal((HEIGHT, WIDTH))
    dark = rng.exponential(200.0, (HEIGHT, WIDTH))
    for kind, exposures in (("flat", FLATS), ("bias", UNLIT[:1]), ("dark", UNLIT[1:])):
        folder = root / kind / "ISO_100"
        folder.mkdir(parents=True)
        for exposure in exposures:
            for number in range(FRAMES):
                electrons = dark * exposure + (15000.0 * exposure * prnu if kind == "flat" else 0.0)
                mosaic = 64.0 + 0.3 * rng.poisson(electrons) + 2.0 * rng.standard_normal((HEIGHT, WIDTH))
                path = folder / f"{kind}_exp{round(exposure * 1e6):09d}us_{number}.dng"
                if number and exposure in left_out:
                    continue
                write_dng(
                    path,
                    np.clip(np.rint(mosaic), 0, 1023).astype(np.uint16),
                    cfa="mono",
                    black_level=[64],
                    white_level=1023,
                    bit_depth=10,
                    iso=100.0,
                    exposure_s=exposure,
                    compression="lossless-jpeg",
                )
                if number and exposure in damaged:
                    whole = path.read_bytes()
                    path.write_bytes(whole[: len(whole) // 2] + b"\xff\xd9" * (len(whole) // 4))
    return root


def rows(study: Path, workers: int) -> list[Row]:
    return list(measure(study, options=Options(workers=workers)).results.rows)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("damaged", [(0.20, 0.22), (0.0001,)], ids=["next to the flats", "shortest"])
def test_other_darks_take_the_place_of_damaged_ones(tmp_path: Path, damaged: tuple[float, ...], workers: int) -> None:
    found = rows(write_study(tmp_path / "damaged", damaged=damaged), workers)
    expected = rows(write_study(tmp_path / "without", left_out=damaged), workers)
    assert {row.quantity for row in found} >= {"prnu", "dsnu"}
    assert found == expected
