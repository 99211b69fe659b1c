"""A chart simulated and written without any code of Fullwell: NumPy for the physics, tifffile for the files.

The camera is METHOD 1's: noise coefficients as published for a Sony A6000, 14 bits, 36 patches 0.2486 D apart, planes
of RGGB at 0.306, 1, 1 and 0.606 of the green signal.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tifffile

STEP = 0.2486
PATCHES = 36
COLUMNS = 9
RESPONSE = {"R": 0.306, "G1": 1.0, "G2": 1.0, "B": 0.606}
SITES = ("R", "G1", "G2", "B")  # RGGB, row by row


@dataclass(frozen=True, kw_only=True)
class Chart:
    """What the frames are made with."""

    k_dark: float = 1.672e-4  # quantization included
    k_shot: float = 5.554e-3
    k_fpn: float = 5.477e-3
    maximum: float = 16383.0
    offset: float = 511.62
    declared_black: int | None = 512  # as near as a whole number can be
    flare: float = 2.4e-4  # of the lightest patch
    brightest: float = 0.93  # signal of G in the lightest patch over the range above black, at exposure 1
    edge: int = 50  # of a patch in pixels of a plane
    gap: int = 12  # between patches and around, in pixels of a plane
    dsnu_share: float = 0.0  # of the dark variance

    @property
    def densities(self) -> np.ndarray:
        return STEP * np.arange(PATCHES)

    @property
    def system_gain(self) -> float:
        return self.maximum * self.k_shot**2

    def light(self, exposure: float) -> np.ndarray:
        """Signal of the green planes above black, patch by patch [DN]."""
        full = exposure * self.brightest * (self.maximum - self.offset)
        return full * (10.0**-self.densities + self.flare)


class Camera:
    """One sensor in front of one chart: its fixed patterns are drawn once."""

    def __init__(self, chart: Chart, seed: int) -> None:
        self.chart = chart
        self.rng = np.random.default_rng(seed)
        rows = -(-PATCHES // COLUMNS)
        pitch = chart.edge + chart.gap
        self.shape = (2 * (rows * pitch + chart.gap), 2 * (COLUMNS * pitch + chart.gap))
        self.prnu = 1.0 + chart.k_fpn * self.rng.standard_normal(self.shape)
        dark = (chart.k_dark * chart.maximum) ** 2 - 1.0 / 12.0
        self.read_noise = float(np.sqrt(dark * (1.0 - chart.dsnu_share)))
        self.dsnu = np.sqrt(dark * chart.dsnu_share) * self.rng.standard_normal(self.shape)
        self.relative = np.full(self.shape, 10.0 ** -chart.densities[-1] + chart.flare)
        for (x, y, size), density in zip(self.places(), chart.densities, strict=True):
            self.relative[y : y + size, x : x + size] = 10.0**-density + chart.flare
        for site, channel in enumerate(SITES):
            self.relative[site // 2 :: 2, site % 2 :: 2] *= RESPONSE[channel]

    def places(self) -> list[tuple[int, int, int]]:
        """x, y and edge of each patch in pixels of the mosaic."""
        chart, pitch = self.chart, self.chart.edge + self.chart.gap
        return [
            (2 * (chart.gap + index % COLUMNS * pitch), 2 * (chart.gap + index // COLUMNS * pitch), 2 * chart.edge)
            for index in range(PATCHES)
        ]

    def frame(self, exposure: float) -> np.ndarray:
        chart, rng = self.chart, self.rng
        signal = exposure * chart.brightest * (chart.maximum - chart.offset) * self.relative * self.prnu
        electrons = rng.poisson(signal / chart.system_gain)
        code = chart.offset + chart.system_gain * electrons + self.dsnu + rng.normal(0.0, self.read_noise, self.shape)
        return np.clip(np.rint(code), 0, chart.maximum).astype(np.uint16)

    def write_patches(self, path: Path, *, densities: Sequence[float] | None = None) -> Path:
        chosen = self.chart.densities if densities is None else densities
        with path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["patch", "x", "y", "width", "height", "density"])
            for index, ((x, y, size), density) in enumerate(zip(self.places(), chosen, strict=True)):
                writer.writerow([f"P{index + 1}", x, y, size, size, f"{density:.4f}"])
        return path

    def write(self, path: Path, exposure: float) -> Path:
        write_dng(path, self.frame(exposure), exposure_s=exposure / 50, black=self.chart.declared_black, white=16383)
        return path


def write_dng(path: Path, mosaic: np.ndarray, *, exposure_s: float, black: int | None, white: int) -> None:
    """Write a minimal uncompressed RGGB DNG."""
    extratags = [
        (50706, 1, 4, bytes((1, 4, 0, 0)), True),  # DNGVersion
        (50708, 2, 0, "Independent", True),  # UniqueCameraModel
        (33421, 3, 2, (2, 2), True),  # CFARepeatPatternDim
        (33422, 1, 4, bytes((0, 1, 1, 2)), True),  # CFAPattern RGGB
        (50717, 4, 1, white, True),  # WhiteLevel
        (34855, 3, 1, 100, True),  # ISOSpeedRatings
        (33434, 5, 1, (round(exposure_s * 1e6), 1_000_000), True),  # ExposureTime
        (271, 2, 0, "Independent", True),
        (272, 2, 0, "Chart", True),
    ]
    if black is not None:
        extratags += [(50713, 3, 2, (1, 1), True), (50714, 3, 1, black, True)]  # BlackLevel
    tifffile.imwrite(path, mosaic, photometric=32803, extratags=extratags, metadata=None, software=False)
