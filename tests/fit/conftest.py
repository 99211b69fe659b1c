"""The sample camera and chart of METHOD, and mean squares by brute force."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from fullwell.statistics.series import MeanSquares

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """METHOD's Sony A6000 before 36 patches 0.2486 D apart, planes R G1 G2 B at .306/1/1/.606 of green.

    Flare of 2e-4 of a plane's maximum reproduces METHOD 1.6's Fisher errors 9.1/14.5/78 and 20/29/128.
    """

    digital_maximum: float = 16383.0
    k: tuple[float, float, float] = (1.672e-4, 5.554e-3, 5.477e-3)
    flare: float = 2e-4
    planes: tuple[float, ...] = (0.306, 1.0, 1.0, 0.606)

    @property
    def truth(self) -> Array:
        """A [DN^2], B [DN/e-], C [1]."""
        return np.square(self.k) * np.array([self.digital_maximum**2, self.digital_maximum, 1.0])

    @property
    def signal_dn(self) -> Array:
        densities = 0.2486 * np.arange(36)
        patches = 0.9169 * (10.0**-densities + self.flare)
        return (np.array(self.planes)[:, None] * patches).ravel() * self.digital_maximum

    @property
    def variance_dn2(self) -> Array:
        a, b, c = self.truth
        return a + b * self.signal_dn + c * self.signal_dn**2

    def simulate(self, rng: np.random.Generator, *, sets: int, n: int) -> tuple[Array, Array]:
        """Measured signals and variances of n pixels each, shapes (sets, points)."""
        shape = (sets, self.signal_dn.size)
        variance = self.variance_dn2 * rng.chisquare(n - 1, shape) / (n - 1)
        return self.signal_dn + rng.normal(size=shape) * np.sqrt(self.variance_dn2 / n), variance


@pytest.fixture
def chart() -> Callable[..., Chart]:
    return Chart


@pytest.fixture
def mean_squares_of() -> Callable[[Array], tuple[MeanSquares, ...]]:
    """Brute force: mean squares of x[set, t, v, h] from the definition of the effects."""

    def compute(x: Array) -> tuple[MeanSquares, ...]:
        axes = {"t": 1, "v": 2, "h": 3}
        names = ("t", "v", "h", "tv", "th", "vh", "tvh")
        squares = {}
        for name in names:
            effect = x
            for letter, axis in axes.items():
                if letter in name:
                    effect = effect - effect.mean(axis=axis, keepdims=True)
                else:
                    effect = effect.mean(axis=axis, keepdims=True)
            weight = np.prod([x.shape[axis] for letter, axis in axes.items() if letter not in name])
            dof = np.prod([x.shape[axis] - 1 for letter, axis in axes.items() if letter in name])
            squares[name] = weight * (effect**2).sum(axis=(1, 2, 3)) / dof
        return tuple(MeanSquares(**{name: float(squares[name][one]) for name in names}) for one in range(x.shape[0]))

    return compute
