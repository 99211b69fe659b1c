"""The black level, from every kind of evidence at once (METHOD 2.3, 2.4).

Photon transfer alone never identifies it: a shift of the offset is absorbed by the coefficients without trace
(METHOD 2.1). Dark frames and exposure brackets do; optical black pixels nearly; a number in the metadata is a rumour
that is good to half a code at best.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from fullwell.fit.pooling import weighted_mean
from fullwell.fit.solvers import root_between
from fullwell.units import DN, Measured

METADATA_STD_ERROR: Final = 0.5 / math.sqrt(3.0)
"""Standard error of a declared level: uniform over half a code either way [DN]."""
DISAGREEMENT: Final = 0.01
"""p-value below which the evidence is said to disagree."""

_TRUST: Final = {
    "exposure-bracket": 0,
    "dark-frames": 0,
    "optical-black": 1,
    "user": 2,
    "metadata": 3,
    "legacy-offset-ratio": 4,
}
_IDENTIFYING: Final = 1
"""Methods up to this rank identify the offset."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """One measurement of the black level, or one declaration of it.

    Parameters
    ----------
    method
        ``dark-frames``, ``exposure-bracket``, ``optical-black``, ``user``, ``metadata``, ``legacy-offset-ratio``.
    measured
        Level with its standard error [DN].

    """

    method: str
    measured: Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class FusedLevel:
    """What all evidence together says.

    Parameters
    ----------
    measured
        The level to use [DN].
    p_value
        Homogeneity of all evidence.
    consistent
        Whether it agrees.
    preferred
        Methods that ``measured`` rests on: all, or the most trustworthy ones where they disagree.
    random_effects_std_error
        Paule-Mandel's standard error of a mean of all evidence, for information where they disagree; it does not cover
        95 % [DN].
    identified
        Whether any evidence identifies the offset; a declared level alone does not.

    """

    measured: Measured
    p_value: float
    consistent: bool
    preferred: tuple[str, ...]
    random_effects_std_error: float | None
    identified: bool


def declared(level_dn: float, *, method: str = "metadata", step: float = 1.0) -> Evidence:
    """Return the evidence of a declared level: uniform over half a code either way."""
    return Evidence(method=method, measured=Measured.normal(level_dn, METADATA_STD_ERROR * step, DN))


def fuse(evidence: Sequence[Evidence]) -> FusedLevel:
    """Return the weighted mean of the evidence, or of the best of it where it disagrees (METHOD 2.4).

    Parameters
    ----------
    evidence
        At least one; each with a standard error above zero.

    Raises
    ------
    ValueError
        Without evidence.

    """
    if not evidence:
        raise ValueError("a black level needs at least one piece of evidence")
    pooled = weighted_mean([piece.measured for piece in evidence])
    consistent = pooled.p_value >= DISAGREEMENT
    chosen = list(evidence) if consistent else _most_trusted(evidence)
    return FusedLevel(
        measured=weighted_mean([piece.measured for piece in chosen]).measured,
        p_value=pooled.p_value,
        consistent=consistent,
        preferred=tuple(piece.method for piece in chosen),
        random_effects_std_error=None if consistent else paule_mandel_std_error([p.measured for p in evidence]),
        identified=min(_rank(piece) for piece in evidence) <= _IDENTIFYING,
    )


def paule_mandel_std_error(measurements: Sequence[Measured]) -> float:
    """Return the standard error of the mean with the between-method variance that makes Q equal its expectation."""
    value = np.array([measured.value for measured in measurements])
    variance = np.array([(measured.std_error or 0.0) ** 2 for measured in measurements])

    def surplus(between: float) -> float:
        weight = 1.0 / (variance + between)
        return float(weight @ (value - weight @ value / weight.sum()) ** 2) - (value.size - 1)

    if value.size < 2 or surplus(0.0) <= 0.0:
        return float(np.sum(1.0 / variance) ** -0.5)
    above = float(np.ptp(value)) ** 2 * value.size
    between = root_between(surplus, 0.0, above)
    return float(np.sum(1.0 / (variance + between)) ** -0.5)


def _most_trusted(evidence: Sequence[Evidence]) -> list[Evidence]:
    best = min(_rank(piece) for piece in evidence)
    return [piece for piece in evidence if _rank(piece) == best]


def _rank(piece: Evidence) -> int:
    return _TRUST.get(piece.method, max(_TRUST.values()))
