"""The fixed pattern of an unlit burst, rounding to whole codes allowed for (METHOD 3.3, 5.1)."""

from fullwell.fit.nonuniformity import Nonuniformity, dark_nonuniformity
from fullwell.fit.read_noise import analogue_read_noise
from fullwell.fit.rounded_pattern import unrounded_nonuniformity
from fullwell.workflow.measure.bursts import Burst
from fullwell.workflow.measure.read_noise import total_temporal_variance


def dark_pattern(burst: Burst, channel: str) -> tuple[Nonuniformity, frozenset[str]]:
    """Return the fixed pattern of one channel of an unlit burst of two frames or more, and the flags of its rows."""
    plane = burst.plane(channel)
    step = plane.code_step
    temporal, n = total_temporal_variance(plane), plane.n * plane.frames
    noise = analogue_read_noise(temporal, quantization_step=step, spatial_spread_dn=plane.body_spread, n=n)
    rounded = dark_nonuniformity(plane.mean_squares, plane.shape, tiles=plane.tiles)
    found, limited = unrounded_nonuniformity(rounded, temporal=temporal, noise=noise, pixels=plane.n, step=step)
    return found, frozenset({"quantization-limited"} if limited else ())
