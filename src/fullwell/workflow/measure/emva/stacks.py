"""The two stacks that fixed pattern is measured in: dark, and at half saturation."""

from dataclasses import dataclass

from fullwell.figures.emva1288.nonuniformity import Split, StackMoments, split_literal, stack_moments
from fullwell.figures.emva1288.package import split_unfiltered
from fullwell.figures.emva1288.sweep import Floats
from fullwell.frames.selection import EXPOSURE_TOLERANCE
from fullwell.statistics.high_pass import SMALLEST_PLANE, filtered
from fullwell.statistics.series import PlaneStatistics
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.wanted import FEWEST_FRAMES


@dataclass(frozen=True, slots=True, kw_only=True)
class Stacks:
    """The bursts; ``bright`` is None where no flats have darks at their exposure."""

    dark: Burst
    bright: Burst | None

    def signal(self, channel: str) -> float:
        """Return the mean of the bright stack less that of the dark one, 0 where there is none [DN]."""
        return 0.0 if self.bright is None else self.bright.plane(channel).mean - self.dark.plane(channel).mean


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Averages:
    """High-passed averages of the stacks of one channel.

    Parameters
    ----------
    dark, response
        Shape (M - 18, N - 18): dark average, and bright less dark; None without a bright stack [DN].
    dark_moments, bright_moments
        Of the high-passed averages.

    """

    dark: Floats
    response: Floats | None
    dark_moments: StackMoments
    bright_moments: StackMoments | None


def choose_stacks(bursts: IsoBursts, channel: str, *, half_saturation: float | None) -> Stacks | None:
    """Return the stacks to use: the one that is nearest to half saturation among those of most frames.

    Parameters
    ----------
    bursts
        All of one ISO.
    channel
        Whose saturation is meant.
    half_saturation
        Signal at half saturation [DN]; None where it is unknown.

    """
    darks = [burst for burst in bursts.darks if _is_stack(burst)]
    if not darks:
        return None
    pairs = [(flat, dark) for flat in bursts.flats if _is_stack(flat) for dark in darks if _together(flat, dark)]
    if not pairs:
        return Stacks(dark=max(darks, key=lambda burst: (burst.frames, -burst.exposure_s)), bright=None)

    def rank(pair: tuple[Burst, Burst]) -> tuple[bool, int, float]:
        flat, dark = pair
        signal = Stacks(dark=dark, bright=flat).signal(channel)
        distance = 0.0 if half_saturation is None else abs(signal - half_saturation)
        return (flat.series.stack is True, min(flat.frames, dark.frames), -distance)

    flat, dark = max(pairs, key=rank)
    return Stacks(dark=dark, bright=flat)


def _is_stack(burst: Burst) -> bool:
    return burst.frames >= FEWEST_FRAMES and burst.series.stack is not False and burst.sums is not None


def _together(flat: Burst, dark: Burst) -> bool:
    return abs(flat.exposure_s - dark.exposure_s) <= EXPOSURE_TOLERANCE * flat.exposure_s


def averages(stacks: Stacks, channel: str) -> Averages | None:
    """Return the averaged stacks, None where the plane is too small for the high-pass filter."""
    plane = stacks.dark.plane(channel)
    if min(plane.rows, plane.columns) < SMALLEST_PLANE:
        return None
    dark = _filtered(stacks.dark, channel)
    dark_moments = _moments(dark, stacks.dark, channel)
    if stacks.bright is None:
        return Averages(dark=dark, response=None, dark_moments=dark_moments, bright_moments=None)
    bright = _filtered(stacks.bright, channel)
    bright_moments = _moments(bright, stacks.bright, channel)
    bright -= dark
    return Averages(dark=dark, response=bright, dark_moments=dark_moments, bright_moments=bright_moments)


def _filtered(burst: Burst, channel: str) -> Floats:
    return filtered(burst.plane_sums(channel), frames=burst.frames)


def pattern_of(found: Averages, signal: float) -> tuple[float, float]:
    """Return the variance of the dark pattern [DN^2] and the relative variance of the response, signed."""
    dark = split_literal(found.dark_moments).total
    if found.bright_moments is None:
        return dark, 0.0
    return dark, (split_literal(found.bright_moments).total - dark) / signal**2


def _moments(plane: Floats, burst: Burst, channel: str) -> StackMoments:
    temporal = burst.plane(channel).temporal_variance
    return stack_moments(plane, frames=burst.frames, temporal=temporal, filtered=True)


def unfiltered_split(plane: PlaneStatistics) -> Split:
    """Return the split of a stack without a filter, as the package has it."""
    squares = plane.mean_squares
    return split_unfiltered(
        rows=plane.rows,
        columns=plane.columns,
        measured=plane.spatial_variance,
        column_means=squares.h * (plane.columns - 1) / (plane.frames * plane.n),
        row_means=squares.v * (plane.rows - 1) / (plane.frames * plane.n),
        left=plane.temporal_variance / plane.frames,
    )
