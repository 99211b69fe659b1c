"""The noise model of a chart as it is drawn: lines over the normalized signal, and the patches beside them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.report.curves import Table
from fullwell.report.drawing import Axes, Key, key
from fullwell.report.drawing.style import QUIET, Marker
from fullwell.report.plots import color_of

MODEL_GRAY = "#c3cbd4"
"""The broad line of the model, which the patches lie on."""
DARK, SHOT, FIXED = "#334155", "#b45309", "#7e22ce"
"""The three parts of the noise: none has the colour of a channel."""
BRIGHTEST = 0.0
_MANY: Final = 1500
"""Patches of one channel from which on they are drawn as pixels."""
_ASIDE: Final = 3.5
"""Between a line and its name [point]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseCurve:
    """A fitted noise model, drawn over the signal divided by the digital maximum.

    Parameters
    ----------
    channel
        Its name, or ``all``.
    dark, shot, fixed_pattern
        Of the variance dark + shot S + fixed_pattern S^2 of one frame [DN^2, DN, 1].
    black_level, digital_maximum
        What the signal S is counted from, and what it is divided by [DN].

    """

    channel: str
    dark: float
    shot: float
    fixed_pattern: float
    black_level: float
    digital_maximum: float

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """Return k_dark, k_shot and k_fpn [1]; NaN where the square came out at or below zero."""
        squares = (self.dark / self.digital_maximum**2, self.shot / self.digital_maximum, self.fixed_pattern)
        dark, shot, fixed = (square**0.5 if square > 0.0 else np.nan for square in squares)
        return dark, shot, fixed

    def noise(self, signal: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the noise at normalized signals, normalized too; NaN where the model has none."""
        at = signal * self.digital_maximum
        variance = self.dark + self.shot * at + self.fixed_pattern * at**2
        return np.sqrt(np.where(variance > 0.0, variance, np.nan)) / self.digital_maximum

    @property
    def detection(self) -> float:
        """Return the normalized signal at which signal and noise are equal; NaN where there is none."""
        grid = np.geomspace(1e-8, 1.0, 4001)
        above = np.flatnonzero(grid >= self.noise(grid))
        return float(grid[above[0]]) if above.size else float("nan")


def noise_curves(table: Table) -> Mapping[str, NoiseCurve]:
    """Return the models of one ISO by channel, from the curve `chart_noise_model`."""
    names = ("dark", "shot", "fixed_pattern", "black_level", "digital_maximum")
    columns = [table.numbers(name).tolist() for name in names]
    return {
        str(channel): NoiseCurve(
            channel=str(channel),
            dark=dark,
            shot=shot,
            fixed_pattern=fixed,
            black_level=black,
            digital_maximum=maximum,
        )
        for channel, dark, shot, fixed, black, maximum in zip(table.values("channel"), *columns, strict=True)
        if np.isfinite([dark, shot, fixed, black, maximum]).all() and maximum > 0.0
    }


def leading_curve(curves: Mapping[str, NoiseCurve]) -> NoiseCurve | None:
    """Return the model that all channels share, or that of the only or first channel; None without any."""
    return curves.get("all") or next(iter(curves.values()), None)


def common_lines(curves: Mapping[str, NoiseCurve]) -> tuple[NoiseCurve, ...]:
    """Return the one model that all channels share; without it that of every channel."""
    return (curves["all"],) if "all" in curves else tuple(curves.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class Patches:
    """The patches of one channel: every array has shape (patches,).

    Parameters
    ----------
    signal, noise
        Over the digital maximum [1].
    residual
        From the channel's own model [standard deviations]; NaN where it took no part.
    used, brightest
        Whether they took part in the fit; whether they are of the brightest exposure.

    """

    channel: str
    signal: NDArray[np.float64]
    noise: NDArray[np.float64]
    residual: NDArray[np.float64]
    used: NDArray[np.bool_]
    brightest: NDArray[np.bool_]

    @property
    def snr(self) -> NDArray[np.float64]:
        """Return signal over noise [dB]; NaN where there is no signal."""
        ratio = np.divide(self.signal, self.noise, out=np.full(self.signal.shape, np.nan), where=self.noise > 0.0)
        return decibel(ratio)


def patches_of(points: Table, digital_maximum: float) -> tuple[Patches, ...]:
    """Return the patches of one ISO by channel, from the curve `chart_points`."""
    return tuple(
        Patches(
            channel=str(channel),
            signal=part.numbers("signal") / digital_maximum,
            noise=np.sqrt(np.maximum(part.numbers("variance"), 0.0)) / digital_maximum,
            residual=part.numbers("residual"),
            used=np.array([value != "no" for value in part.values("used")]),
            brightest=part.numbers("exposure") == BRIGHTEST,
        )
        for channel, part in points.split("channel")
    )


def decibel(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 20 log10 of ratios, NaN for those that are not positive."""
    return 20.0 * np.log10(np.where(ratio > 0.0, ratio, np.nan))


def scatter(axes: Axes, patches: Patches, values: NDArray[np.float64], *, size: float = 5.0) -> None:
    """Draw patches as circles: filled at the brightest exposure, hollow below, crosses where they took no part."""
    color = color_of(patches.channel)
    kinds: tuple[tuple[NDArray[np.bool_], Marker, str, str, float], ...] = (
        (patches.used & patches.brightest, "o", color, color, 0.8),
        (patches.used & ~patches.brightest, "o", color, "white", 1.0),
        (~patches.used, "x", QUIET, QUIET, 1.0),
    )
    for chosen, marker, edge, face, alpha in kinds:
        axes.plot(
            patches.signal[chosen],
            values[chosen],
            linestyle="none",
            marker=marker,
            color=edge,
            markerfacecolor=face,
            alpha=alpha,
            markersize=size,
            zorder=4.0,
            dense=bool(chosen.sum() > _MANY),
        )


def model_line(axes: Axes, signal: NDArray[np.float64], values: NDArray[np.float64], *, width: float) -> None:
    """Draw the broad line of a model, which the patches lie on."""
    axes.plot(signal, values, color=MODEL_GRAY, linewidth=width, rounded=True, zorder=1.5)


def channel_circles(channels: Iterable[str]) -> list[Key]:
    """Return the legend of channels that are drawn as circles."""
    return [
        key(
            channel,
            color=color_of(channel),
            marker="o",
            markerfacecolor=color_of(channel),
            linestyle="none",
            alpha=0.85,
        )
        for channel in channels
    ]


def circle_keys(every: Sequence[Patches]) -> list[Key]:
    """Return the legend of channels, exposures and patches that took no part."""
    keys = channel_circles(one.channel for one in every)
    if any((one.used & ~one.brightest).any() for one in every):
        keys.append(key("darker exposure", color=QUIET, linestyle="none", marker="o"))
    if any((~one.used).any() for one in every):
        keys.append(key("not used", color=QUIET, linestyle="none", marker="x"))
    return keys


def model_key() -> Key:
    """Return the legend of the broad line of the model."""
    return key("noise model", color=MODEL_GRAY, linewidth=4.0)


def normalized_axes(axes: Axes) -> None:
    """Make both axes of normalized values logarithmic: powers of ten alone, small ticks between them."""
    axes.set_xscale("powers")
    axes.set_yscale("powers")


def along(axes: Axes, text: str, at: tuple[float, float], *, slope: float, color: str, below: bool = False) -> None:
    """Write along a straight line: beside it, from a point of it on.

    Parameters
    ----------
    axes, text
        Where, and what.
    at
        x and y of the point.
    slope
        Of the line in units of the axes' scales: decades on logarithmic axes.
    color
        Of the line.
    below
        Whether to write below the line rather than above.

    """
    axes.text(
        *at,
        text,
        slope=slope,
        offset=(0.0, -_ASIDE if below else _ASIDE),
        va="top" if below else "bottom",
        color=color,
        size=8.0,
        zorder=5.0,
    )
