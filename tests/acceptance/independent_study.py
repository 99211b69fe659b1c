"""A study simulated and written without any code of Fullwell: NumPy for the physics, tifffile for the files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tifffile

BGGR = {(0, 0): "B", (0, 1): "G2", (1, 0): "G1", (1, 1): "R"}
RESPONSE = {"R": 0.55, "G1": 1.0, "G2": 1.0, "B": 0.65}
FLAT_EXPOSURES_S = (0.002, 0.004, 0.006, 0.008, 0.010)
DARK_EXPOSURES_S = (0.5, 1.0, 2.0, 3.0, 4.0)
BIAS_EXPOSURE_S = 1e-4


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What the frames were made with."""

    width: int = 512
    height: int = 384
    isos: tuple[int, ...] = (100, 400)
    system_gain: float = 0.45  # DN/e- at ISO 100
    black: int = 200
    white: int = 4095
    read_noise_pre: float = 2.4  # e-
    read_noise_post: float = 0.9  # DN
    row_noise: float = 0.25  # e-
    dark_current: float = 5.0  # e-/s
    dsnu: float = 0.8  # e-
    prnu: float = 0.006
    flux: float = 300_000.0  # e-/s at response 1, centre, ISO 100; divided by the amplification at higher ISO
    flats: int = 4
    darks: int = 4
    biases: int = 5

    def amplification(self, iso: int) -> float:
        return iso / 100.0

    def gain_at(self, iso: int) -> float:
        return self.system_gain * self.amplification(iso)

    def read_noise_dn(self, iso: int) -> float:
        pre = np.hypot(self.read_noise_pre, self.row_noise) * self.gain_at(iso)
        return float(np.hypot(pre, self.read_noise_post))


class Sensor:
    """One sensor: its fixed patterns are drawn once."""

    def __init__(self, truth: Truth, seed: int) -> None:
        self.truth = truth
        self.rng = np.random.default_rng(seed)
        shape = (truth.height, truth.width)
        self.offset_e = self.rng.normal(0.0, truth.dsnu, shape)
        self.sensitivity = 1.0 + self.rng.normal(0.0, truth.prnu, shape)
        response = np.empty(shape)
        for (row, column), channel in BGGR.items():
            response[row::2, column::2] = RESPONSE[channel]
        y, x = np.mgrid[: truth.height, : truth.width]
        radius2 = ((x / truth.width - 0.5) ** 2 + (y / truth.height - 0.5) ** 2) * 0.6
        self.illumination = response / (1.0 + radius2) ** 2

    def frame(self, *, iso: int, exposure_s: float, lit: bool) -> np.ndarray:
        truth, rng = self.truth, self.rng
        mean = np.full((truth.height, truth.width), truth.dark_current * exposure_s)
        if lit:
            mean = mean + truth.flux / truth.amplification(iso) * exposure_s * self.illumination * self.sensitivity
        electrons = rng.poisson(mean) + self.offset_e + rng.normal(0.0, truth.read_noise_pre, mean.shape)
        electrons += rng.normal(0.0, truth.row_noise, (truth.height, 1))
        code = truth.black + truth.gain_at(iso) * electrons + rng.normal(0.0, truth.read_noise_post, mean.shape)
        return np.clip(np.rint(code), 0, truth.white).astype(np.uint16)


def write_dng(path: Path, mosaic: np.ndarray, *, iso: int, exposure_s: float, black: int, white: int) -> None:
    """Write a minimal uncompressed BGGR DNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    exposure = (round(exposure_s * 1e6), 1_000_000)
    extratags = [
        (50706, 1, 4, bytes((1, 4, 0, 0)), True),  # DNGVersion
        (50708, 2, 0, "Independent", True),  # UniqueCameraModel
        (33421, 3, 2, (2, 2), True),  # CFARepeatPatternDim
        (33422, 1, 4, bytes((2, 1, 1, 0)), True),  # CFAPattern BGGR
        (50713, 3, 2, (2, 2), True),  # BlackLevelRepeatDim
        (50714, 3, 4, (black,) * 4, True),  # BlackLevel
        (50717, 4, 1, white, True),  # WhiteLevel
        (34855, 3, 1, iso, True),  # ISOSpeedRatings
        (33434, 5, 1, exposure, True),  # ExposureTime
        (271, 2, 0, "Independent", True),
        (272, 2, 0, "Simulated", True),
    ]
    tifffile.imwrite(path, mosaic, photometric=32803, extratags=extratags, metadata=None, software=False)


def write_study(root: Path, truth: Truth, *, seed: int, dark_exposures_s: tuple[float, ...] = DARK_EXPOSURES_S) -> None:
    """Write flats, darks and bias frames at every ISO."""
    sensor = Sensor(truth, seed)
    for iso in truth.isos:
        plan = [("flat", t, True, truth.flats) for t in FLAT_EXPOSURES_S]
        plan += [("dark", t, False, truth.darks) for t in dark_exposures_s]
        plan += [("bias", BIAS_EXPOSURE_S, False, truth.biases)]
        for kind, exposure_s, lit, frames in plan:
            for index in range(frames):
                path = root / kind / f"ISO_{iso}" / f"{round(exposure_s * 1e6):08d}_{index}.dng"
                mosaic = sensor.frame(iso=iso, exposure_s=exposure_s, lit=lit)
                write_dng(path, mosaic, iso=iso, exposure_s=exposure_s, black=truth.black, white=truth.white)
