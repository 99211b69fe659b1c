"""The published read-noise flows, from exact sums of the first five frames (METHOD 3.2)."""

from dataclasses import dataclass
from typing import Final

from fullwell.kernels.moments_summary import sum_maps
from fullwell.statistics.exact import total_of
from fullwell.statistics.moments import Moments
from fullwell.statistics.series import LegacyBurst

LEGACY_FRAMES: Final = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstSums:
    """Exact sums of a burst over some pixels.

    Parameters
    ----------
    frame_sums
        Sum over pixels of each frame.
    pixels
        How many.
    squares
        Sum over pixels and frames of x^2.
    squared_sums
        Sum over pixels of the squared sum over frames.

    """

    frame_sums: tuple[int, ...]
    pixels: int
    squares: int
    squared_sums: int

    def __add__(self, other: "BurstSums") -> "BurstSums":
        """Return the sums over the pixels of both."""
        return BurstSums(
            frame_sums=tuple(a + b for a, b in zip(self.frame_sums, other.frame_sums, strict=True)),
            pixels=self.pixels + other.pixels,
            squares=self.squares + other.squares,
            squared_sums=self.squared_sums + other.squared_sums,
        )

    def legacy(self) -> LegacyBurst | None:
        """Return the two published variances, or None where they do not exist.

        Both follow from the same sum over pairs i < j of the scatter of x_i - x_j, so their ratio is exactly
        2 L / (L - 1) [DN^2].
        """
        frames, n = len(self.frame_sums), self.pixels
        if frames < 2 or n < 2:
            return None
        between_frames = frames * sum(g * g for g in self.frame_sums) - sum(self.frame_sums) ** 2
        over_pairs = (frames * self.squares - self.squared_sums) * n - between_frames
        scale = n * (n - 1)
        return LegacyBurst(
            frames=frames,
            n=n,
            pair_variance=2 * over_pairs / (scale * frames * (frames - 1)),
            residual_variance=over_pairs / (scale * frames * frames),
        )


def burst_sums(moments: Moments) -> tuple[BurstSums, ...]:
    """Return the sums of a burst, one per plane, from moments that hold nothing else."""
    layout, names = moments.layout, moments.names
    sums = sum_maps(moments.finished(), layout.cell)
    bursts: list[BurstSums] = []
    for site in range(layout.sites):
        rows, columns = layout.plane(site)
        squares, low, high = (total_of(part[site]) for part in sums)
        bursts.append(
            BurstSums(
                frame_sums=tuple(moments.frame_sums[name][site] for name in names),
                pixels=rows * columns,
                squares=squares,
                squared_sums=low + (high << 32),
            )
        )
    return tuple(bursts)
