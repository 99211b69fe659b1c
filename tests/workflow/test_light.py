"""Flats under a covered lens, and unlit frames that light reached: both are said, and only then."""

import re
from pathlib import Path

import numpy as np
import pytest

from fullwell.raw.write import write_dng
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options
from fullwell.workflow.spanning import Measurement

UNLIT = {"bias": (0.0001,), "dark": (0.5, 1.0, 2.0)}
FLATS = (0.01, 0.02, 0.04)


def measured(folder: Path, *, flat_light: float = 1.0, lit: tuple[float, ...] = ()) -> Measurement:
    """Measure a study of 25,000 e-/s in its flats, of which a share arrives; 300 e- reach some unlit series."""
    rng = np.random.default_rng(3)
    for kind, exposures in (*UNLIT.items(), ("flat", FLATS)):
        for exposure in exposures:
            electrons = 4.0 * exposure + (300.0 if exposure in lit else 0.0)
            electrons += 25_000.0 * flat_light * exposure if kind == "flat" else 0.0
            for number in range(3):
                codes = 64.0 + 0.5 * rng.poisson(electrons, (64, 96)) + rng.normal(0.0, 1.5, (64, 96))
                path = folder / kind / "ISO_100" / f"exp{round(exposure * 1e6):09d}us_{number}.dng"
                path.parent.mkdir(parents=True, exist_ok=True)
                write_dng(
                    path,
                    np.rint(codes).clip(0, 4095).astype(np.uint16),
                    cfa="RGGB",
                    black_level=[64] * 4,
                    white_level=4095,
                    iso=100.0,
                    exposure_s=exposure,
                )
    return measure(folder, options=Options(workers=1))


def said(found: Measurement) -> set[str]:
    return {finding.code for finding in found.results.findings} & {"flats-without-light", "unlit-off-line"}


def test_a_covered_lens_is_said_and_nothing_is_made_of_its_flats(tmp_path: Path) -> None:
    found = measured(tmp_path, flat_light=0.0)
    assert said(found) == {"flats-without-light"}
    assert "no-flat-frames" not in {finding.code for finding in found.results.findings}
    quantities = {row.quantity for row in found.results.rows}
    assert {"read_noise", "dark_current"} <= quantities
    assert not quantities & {"system_gain", "saturation_capacity", "snr_max", "prnu"}


@pytest.mark.parametrize("flat_light", [1.0, 0.003], ids=["plain", "faint"])
def test_of_frames_that_are_as_they_should_be_nothing_is_said(tmp_path: Path, flat_light: float) -> None:
    """The brightest of the faint flats has 3 e-, half the noise of a pixel."""
    found = measured(tmp_path, flat_light=flat_light)
    assert not said(found)
    assert "system_gain" in {row.quantity for row in found.results.rows}


@pytest.mark.parametrize("lit", [0.0001, 1.0, 2.0])
def test_unlit_frames_that_light_reached_are_named_with_their_means(tmp_path: Path, lit: float) -> None:
    found = measured(tmp_path, lit=(lit,))
    assert said(found) == {"unlit-off-line"}
    (finding,) = (one for one in found.results.findings if one.code == "unlit-off-line")
    means = [float(part) for part in re.findall(r"([0-9.]+) DN at", finding.message)]
    most_dark_dn = 0.5 * 4.0 * 2.0
    light_dn = means[(0.0001, 0.5, 1.0, 2.0).index(lit)] - min(means)
    assert 0.5 * 300.0 - 1.0 < light_dn < 0.5 * 300.0 + most_dark_dn + 1.0
