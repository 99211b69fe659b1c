"""Planes of bins with a known shading and known noise."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from fullwell.fit.shading.data import ShadingData

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """METHOD T17's camera: 0.17 DN/e-, read noise 1.5 DN, PRNU .7 %, five frames; bins of 8 x 8 pixels of 2.8 um."""

    bins: tuple[int, int] = (189, 252)
    size: int = 8

    @property
    def shape(self) -> tuple[int, int]:
        return self.bins[0] * self.size, self.bins[1] * self.size

    @property
    def rows(self) -> Array:
        return np.arange(self.bins[0]) * self.size + (self.size - 1) / 2.0

    @property
    def columns(self) -> Array:
        return np.arange(self.bins[1]) * self.size + (self.size - 1) / 2.0

    def cosine(self, row: Array, column: Array, *, power: float = 2.0, reach: float = 1.24) -> Array:
        """(1 + r^2/f^2)^-power about (.52, .49) of the plane; f in half diagonals."""
        vertical, horizontal = row - 0.52 * self.shape[0], column - 0.49 * self.shape[1]
        focal = reach * np.hypot(*self.shape) / 2.0
        return (1.0 + (vertical**2 + horizontal**2) / focal**2) ** -power

    def on_bins(self, function: Callable[..., Array], **options: float) -> Array:
        return function(self.rows[:, None], self.columns[None, :], **options) * np.ones(self.bins)

    def temporal_variance(self, signal: Array) -> Array:
        return (0.17 * np.maximum(signal, 0.0) + 1.5**2) / (5 * self.size**2)

    def pattern(self, rng: np.random.Generator) -> Array:
        return 0.007 / self.size * rng.normal(size=self.bins)

    def data(self, signal: Array, rng: np.random.Generator, *, pattern: Array | None = None) -> ShadingData:
        """One burst: ``signal`` DN per bin, PRNU (a given one is the same sensor again), temporal noise."""
        fixed = self.pattern(rng) if pattern is None else pattern
        variance = self.temporal_variance(signal)
        return ShadingData(
            rows=self.rows,
            columns=self.columns,
            signal_dn=signal * (1.0 + fixed) + rng.normal(size=self.bins) * np.sqrt(variance),
            temporal_variance_dn2=variance,
            fixed_variance=np.full(self.bins, (0.007 / self.size) ** 2),
            plane_shape=self.shape,
            pitch_um=2.8,
            focal_length_mm=4.38,
        )


@pytest.fixture
def bench() -> Callable[..., Bench]:
    return Bench
