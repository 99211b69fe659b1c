"""Masked pixels of a study's frames: a row of their own, evidence where no dark frames tell, told where they differ."""

from pathlib import Path

import numpy as np
import pytest

from fullwell.figures.results import Results
from fullwell.frames.selection import Selection
from fullwell.raw.image import Area
from fullwell.raw.write import DngExtras, write_dng
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options

BLACK = 256.0
MARGIN = 48


def study(folder: Path, *, darks: bool, masked_level: float = BLACK, masked_noise: float = 2.0) -> Results:
    """Measure flats, and darks if asked for, whose left 48 columns are masked."""
    rng = np.random.default_rng(3)
    extras = DngExtras(active_area=Area(0, MARGIN, 192, 304), masked_areas=(Area(0, 0, 192, MARGIN),))
    levels = [("flat", 0.01 * k, 400.0 * k) for k in (1, 2, 4)] + [("bias", 0.0001, 0.0)] * darks
    for kind, exposure_s, electrons in levels:
        for number in range(3):
            active = BLACK + 0.5 * rng.poisson(electrons, (192, 256)) + rng.normal(0.0, 2.0, (192, 256))
            margin = rng.normal(masked_level, masked_noise, (192, MARGIN))
            path = folder / kind / f"{exposure_s:g}_{number}.dng"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_dng(
                path,
                np.round(np.hstack([margin, active])).astype(np.uint16),
                cfa="RGGB",
                black_level=(250.0,),
                white_level=4095,
                iso=100,
                exposure_s=exposure_s,
                extras=extras,
            )
    return measure(folder, options=Options(selection=Selection(), workers=1)).results


def levels(results: Results, method: str) -> dict[str, float]:
    return {
        row.channel: row.measured.value for row in results.rows if (row.quantity, row.method) == ("black_level", method)
    }


def codes(results: Results) -> set[str]:
    return {finding.code for finding in results.findings}


def test_masked_pixels_tell_the_level_where_no_dark_frames_do(tmp_path: Path) -> None:
    results = study(tmp_path, darks=False)
    masked = [row for row in results.rows if row.method == "optical-black"]
    assert [row.channel for row in masked] == ["R", "G1", "G2", "B"]
    for row in masked:
        assert abs(row.measured.value - BLACK) < 5.0 * (row.measured.std_error or 0.0)
    # the tag of 250 is six codes off: masked pixels are believed, and the disagreement is told
    assert levels(results, "fused")["R"] == pytest.approx(BLACK, abs=0.5)
    assert "black-levels-disagree" in codes(results)


def test_dark_frames_are_believed_before_masked_pixels(tmp_path: Path) -> None:
    results = study(tmp_path, darks=True, masked_level=BLACK - 7.0)
    assert levels(results, "dark-frames")["G1"] == pytest.approx(BLACK, abs=0.1)
    assert levels(results, "fused")["G1"] == pytest.approx(BLACK, abs=0.1)
    assert levels(results, "optical-black")["G1"] == pytest.approx(BLACK - 7.0, abs=0.2)
    assert "optical-black-differs" in codes(results)
    assert "optical-black-noisier" not in codes(results)


def test_noisy_masked_pixels_are_no_evidence(tmp_path: Path) -> None:
    results = study(tmp_path, darks=True, masked_noise=5.0)
    assert "optical-black-noisier" in codes(results)
