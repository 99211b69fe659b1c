"""Degrees of freedom of sums of errors."""

import numpy as np
import pytest

from fullwell.units import combined_dof, student_975, welch_dof

TRIALS = 4000


@pytest.mark.parametrize("known", [None, 10.0])
@pytest.mark.parametrize("few", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("ratio", [0.03, 0.1, 0.3, 1.0, 3.0])
def test_sums_are_known_no_better_than_their_parts(ratio: float, few: float, known: float | None) -> None:
    rng = np.random.default_rng(17)
    off = rng.normal(size=TRIALS) + ratio * rng.normal(size=TRIALS)
    first = np.sqrt(rng.chisquare(few, TRIALS) / few)
    second = ratio * (np.ones(TRIALS) if known is None else np.sqrt(rng.chisquare(known, TRIALS) / known))
    half = [
        student_975(combined_dof((one, few), (other, known))) * np.hypot(one, other)
        for one, other in zip(first, second, strict=True)
    ]
    held = np.mean(np.abs(off) <= half)
    # The interval of the part of few is never undercut, so that up to 98 % are true with one degree of freedom, 96 with
    # more; four Monte Carlo errors either way.
    for share, side in ((0.95, 1.0), (0.98 if few == 1.0 else 0.96, -1.0)):
        assert side * (held - share) >= -4.0 * np.sqrt(share * (1.0 - share) / TRIALS)


def test_many_degrees_of_freedom_are_those_of_welch() -> None:
    parts = ((1.0, 8.0), (0.3, None), (0.5, 30.0))
    assert combined_dof(*parts) == welch_dof(*parts)
    assert combined_dof((0.0, 1.0), (1.0, None)) is None
