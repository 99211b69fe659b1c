"""Curves of the stacks: spectrograms, profiles, histograms of the dark signal and of the response."""

from itertools import chain, repeat

import numpy as np

from fullwell.figures.emva1288.histogram import StackHistogram, accumulated, normal_counts, stack_histogram
from fullwell.figures.emva1288.nonuniformity import split_literal
from fullwell.figures.emva1288.profile import Profile, profiles
from fullwell.figures.emva1288.spectrogram import frequencies, power_spectrum
from fullwell.figures.emva1288.sweep import Floats
from fullwell.figures.results import Curve
from fullwell.units import DN, ONE, PERCENT
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.emva.stacks import Averages, Stacks
from fullwell.workflow.measure.emva.tables import Columns, Values, table
from fullwell.workflow.measure.emva.writer import LINEAR

_DIRECTIONS = ("horizontal", "vertical")


def spatial_curves(bursts: IsoBursts, channel: str, stacks: Stacks, found: Averages) -> tuple[Curve, ...]:
    """Return the curves of the dark stack, and of the response where there is a bright one."""
    dark_plane = stacks.dark.plane(channel)
    dark = split_literal(found.dark_moments)
    writer = _StackCurves(bursts, channel, "dsnu", unit=DN)
    curves = writer.curves(
        along=profiles(stacks.dark.plane_sums(channel), stacks.dark.frames),
        filtered=found.dark,
        frames=stacks.dark.frames,
        lines=(dark.total, dark_plane.temporal_variance),
        scale=1.0,
    )
    if stacks.bright is None or found.bright_moments is None or found.response is None:
        return curves
    bright_plane, bright = stacks.bright.plane(channel), split_literal(found.bright_moments)
    writer = _StackCurves(bursts, channel, "prnu", unit=PERCENT)
    return (
        *curves,
        *writer.curves(
            along=profiles(
                stacks.bright.plane_sums(channel),
                stacks.bright.frames,
                less=(stacks.dark.plane_sums(channel), stacks.dark.frames),
            ),
            filtered=found.response,
            frames=stacks.bright.frames,
            lines=(bright.total - dark.total, bright_plane.temporal_variance),
            scale=100.0 / stacks.signal(channel),
        ),
    )


class _StackCurves:
    """Writes the curves of one image."""

    def __init__(self, bursts: IsoBursts, channel: str, pattern: str, *, unit: str) -> None:
        self._bursts, self._channel, self._pattern, self._unit = bursts, channel, pattern, unit

    def curves(
        self,
        *,
        along: tuple[Profile, Profile],
        filtered: Floats,
        frames: int,
        lines: tuple[float, float],
        scale: float,
    ) -> tuple[Curve, ...]:
        """Return spectrograms, profiles and histograms.

        Parameters
        ----------
        along
            Profiles of the averaged image as it is.
        filtered
            The same high-passed [DN].
        frames
            Frames of the stack.
        lines
            Variances drawn as horizontal lines: fixed pattern, and temporal of one frame [DN^2].
        scale
            From DN to the unit of spectrograms.

        """
        return (
            self._spectrograms(filtered, lines, scale),
            self._profiles(along),
            self._histogram(filtered, frames),
            self._accumulated(filtered, frames),
        )

    def _spectrograms(self, filtered: Floats, lines: tuple[float, float], scale: float) -> Curve:
        planes = (filtered, filtered.T)
        found = [scale * np.sqrt(power_spectrum(plane)) for plane in planes]
        pattern, temporal = (scale * np.sqrt(max(variance, 0.0)) for variance in lines)
        steps = sum(one.size for one in found)
        columns: Columns = (
            ("direction", "", _labels(*(one.size for one in found))),
            ("frequency", "cycles/pixel", np.concatenate([frequencies(plane.shape[1]) for plane in planes])),
            ("amplitude", self._unit, np.concatenate(found)),
            ("pattern", self._unit, np.full(steps, pattern)),
            ("temporal", self._unit, np.full(steps, temporal)),
        )
        return self._table("spectrogram", steps, columns)

    def _profiles(self, both: tuple[Profile, Profile]) -> Curve:
        sizes = [one.mean.size for one in both]

        def column(name: str) -> tuple[str, str, Values]:
            return name, DN, np.concatenate([_line(one, name) for one in both])

        columns: Columns = (
            ("direction", "", _labels(*sizes)),
            ("index", "pixel", np.concatenate([np.arange(size) for size in sizes])),
            column("middle"),
            column("mean"),
            column("maximum"),
            column("minimum"),
        )
        return self._table("profile", sum(sizes), columns)

    def _histogram(self, filtered: Floats, frames: int) -> Curve:
        found, mean = stack_histogram(filtered, frames=frames), float(filtered.mean())
        variance = float(np.einsum("ij,ij->", filtered, filtered)) / filtered.size - mean**2
        columns: Columns = (
            ("deviation", DN, found.centres - mean),
            ("pixels", ONE, found.counts),
            ("model", ONE, normal_counts(found, mean=mean, variance=variance)),
        )
        return self._table("histogram", found.counts.size, columns)

    def _accumulated(self, filtered: Floats, frames: int) -> Curve:
        found: StackHistogram = accumulated(filtered, frames=frames)
        columns: Columns = (
            ("deviation", DN, found.centres),
            ("share", PERCENT, 100.0 * found.counts / filtered.size),
            ("pixels", ONE, found.counts),
        )
        return self._table("accumulated", found.counts.size, columns)

    def _table(self, name: str, steps: int, columns: Columns) -> Curve:
        full = f"emva_{name}_{self._pattern}"
        return table(full, self._bursts, self._channel, method=LINEAR, steps=steps, columns=columns)


def _labels(*sizes: int) -> tuple[str, ...]:
    return tuple(chain.from_iterable(map(repeat, _DIRECTIONS, sizes)))


def _line(profile: Profile, name: str) -> Floats:
    return {"middle": profile.middle, "mean": profile.mean, "maximum": profile.maximum, "minimum": profile.minimum}[
        name
    ]
