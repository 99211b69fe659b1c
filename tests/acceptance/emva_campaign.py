"""An EMVA 1288 campaign made without Fullwell: NumPy physics and Pillow, and a descriptor of the emva1288 package."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What the simulated camera has."""

    system_gain: float = 0.4
    quantum_efficiency: float = 60.0
    dark_noise_e: float = 2.4
    dsnu_e: float = 0.7
    prnu_percent: float = 0.68
    dark_current_e: float = 20.0
    black_dn: float = 60.0
    top_code: int = 4095
    saturation_electrons: float = 11500.0


def take(folder: Path, *, side: int = 1000, steps: int = 50, stack: int = 50, seed: int = 0) -> Path:
    """Write images and their descriptor; exposure times from 0.2 to 10 ms at constant light.

    Every step has two bright and two dark frames; 50 bright and 50 dark frames lie at half of saturation.
    """
    truth, rng = Truth(), np.random.default_rng(seed)
    shape = (side, side)
    dark_e = rng.normal(0.0, truth.dsnu_e, shape)
    response = rng.normal(1.0, truth.prnu_percent / 100.0, shape)
    (folder / "img").mkdir(parents=True)
    lines = ["v 4.0", f"n 12 {side} {side}"]

    def block(head: str, name: str, exposure_s: float, electrons: float, count: int) -> None:
        lines.append(head)
        mean = electrons * response + truth.dark_current_e * exposure_s
        for number in range(count):
            charge = rng.poisson(mean) + dark_e + rng.normal(0.0, truth.dark_noise_e, shape)
            codes = np.rint(truth.system_gain * charge + truth.black_dn).clip(0, truth.top_code).astype(np.uint16)
            path = f"img/{name}_{number:03d}.png"
            Image.fromarray(codes).save(folder / path, compress_level=1)
            lines.append("i " + path.replace("/", "\\"))

    efficiency = truth.quantum_efficiency / 100.0
    for step in range(1, steps + 1):
        exposure_s = 0.01 * step / steps
        electrons = truth.saturation_electrons * step / steps
        count, name = 2, f"s{step:02d}"
        nanoseconds = f"{exposure_s * 1e9:.1f}"
        block(f"b {nanoseconds} {electrons / efficiency!r}", f"{name}b", exposure_s, electrons, count)
        block(f"d {nanoseconds}", f"{name}d", exposure_s, 0.0, count)
    half = steps * 9 // 20
    exposure_s, electrons = 0.01 * half / steps, truth.saturation_electrons * half / steps
    nanoseconds = f"{exposure_s * 1e9:.1f}"
    block(f"b {nanoseconds} {electrons / efficiency!r}", "p50", exposure_s, electrons, stack)
    block(f"d {nanoseconds}", "d50", exposure_s, 0.0, stack)
    descriptor = folder / "campaign.txt"
    descriptor.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return descriptor
