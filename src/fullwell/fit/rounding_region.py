"""What rounded codes of little noise leave possible: every noise and pattern that some phase of the code explains.

Both variances, that of frames and that of pixels, depend on where the level lies between two codes. Near the middle of
one, noise below a third of a code hardly shows; at the edge of two, codes flip at any noise and their variance is a
quarter. So all three, noise, pattern and phase, are looked through together (METHOD 3.3).
"""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.model.quantization import rounded_pattern_at_phase, rounded_variance_at_phase

_NOISES: Final = np.geomspace(0.02, 1.2, 90)
_PATTERNS: Final = np.concatenate([np.zeros(1), np.geomspace(0.004, 1.5, 90)])
_PHASES: Final = np.linspace(0.0, 0.5, 17)

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Possible:
    """Standard deviations before rounding, lowest and highest, in codes; a lower end of 0 stands for none."""

    noise: Range
    pattern: Range


def possible_before_rounding(temporal: Range, pattern: Range) -> Possible | None:
    """Return the noise and the pattern that codes may come from.

    Parameters
    ----------
    temporal
        Ends of the temporal variance of rounded codes [code^2].
    pattern
        Ends of the variance over pixels of their means, free of temporal noise [code^2].

    Returns
    -------
    Possible or None
        None where no normal noise and pattern explain both.

    Examples
    --------
    >>> found = possible_before_rounding((0.245, 0.255), (0.0, 1e-3))
    >>> found is not None and (found.noise[0], round(found.noise[1], 2))
    (0.0, 0.46)

    """
    shown_low, shown_high, seen_low, seen_high = _cells()
    cells = (shown_low <= temporal[1]) & (shown_high >= temporal[0]) & (seen_low <= pattern[1])
    noises, patterns, _ = np.nonzero(cells & (seen_high >= pattern[0]))
    if not noises.size:
        return None
    least = int(noises.min())
    return Possible(
        noise=(float(_NOISES[least]) if least else 0.0, float(_NOISES[noises.max() + 1])),
        pattern=(float(_PATTERNS[patterns.min()]), float(_PATTERNS[patterns.max() + 1])),
    )


@cache
def _cells() -> tuple[NDArray[np.float64], ...]:
    """Return the least and the largest temporal variance and pattern in each cell of noise, pattern and phase."""
    seen = np.stack(
        [rounded_pattern_at_phase(_PATTERNS[:, np.newaxis], _PHASES, noise=float(noise)) for noise in _NOISES]
    )
    together = np.hypot(_NOISES[:, np.newaxis], _PATTERNS)
    fine = np.geomspace(float(together.min()), float(together.max()), 200)
    whole = rounded_variance_at_phase(fine[:, np.newaxis], _PHASES)
    shown = np.stack([np.interp(together, fine, column) for column in whole.T], axis=-1) - seen
    return (*_ends(shown), *_ends(seen))


def _ends(nodes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least and the largest of the corners of each cell."""
    low = high = nodes
    for axis in range(nodes.ndim):
        first, second = (np.take(low, range(start, low.shape[axis] - 1 + start), axis) for start in (0, 1))
        top, bottom = (np.take(high, range(start, high.shape[axis] - 1 + start), axis) for start in (0, 1))
        low, high = np.minimum(first, second), np.maximum(top, bottom)
    return low, high
