"""THE table: every quantity with its symbol, units, equation, definition and source; report, docs and tests read it.

`quantity`, `method` and `flag` look one entry up by the name it has in the rows; `citations` lists the
bibliography behind the ``source`` of rows. Subjects stand in one file each: temporal, spatial, merit, emva,
methods, flags, bibliography.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from fullwell.glossary.bibliography import BIBLIOGRAPHY
from fullwell.glossary.emva import EMVA
from fullwell.glossary.entry import Flag, Method, Quantity, Reference
from fullwell.glossary.flags import FLAGS, RECOMMENDED
from fullwell.glossary.merit import RANGE, SNR_THRESHOLDS
from fullwell.glossary.methods import METHODS
from fullwell.glossary.spatial import NONUNIFORMITY, SHADING
from fullwell.glossary.temporal import DARK_CURRENT, LEVELS, PHOTON_TRANSFER, READ_NOISE

__all__ = [
    "BIBLIOGRAPHY",
    "FLAGS",
    "METHODS",
    "QUANTITIES",
    "RECOMMENDED",
    "SNR_THRESHOLDS",
    "Flag",
    "Method",
    "Quantity",
    "Reference",
    "citations",
    "flag",
    "method",
    "quantity",
]

QUANTITIES: Final = (
    *LEVELS,
    *READ_NOISE,
    *DARK_CURRENT,
    *PHOTON_TRANSFER,
    *RANGE,
    *NONUNIFORMITY,
    *SHADING,
    *EMVA,
)
"""Every quantity in the order reports use; the signed twins ``<name>_variance`` follow by rule, see `quantity`."""

_TWIN: Final = "_variance"


def quantity(name: str) -> Quantity | None:
    """Return the definition of a quantity, or None where the glossary has none.

    Examples
    --------
    >>> quantity("read_noise").units
    ('DN', 'e-', 'V')
    >>> quantity("read_noise_variance").units
    ('DN^2', 'e-^2', 'V^2')

    """
    entry = next((entry for entry in QUANTITIES if entry.name == name), None)
    if entry is None and name.endswith(_TWIN):
        root = quantity(name.removesuffix(_TWIN))
        return None if root is None or not root.signed_twin else _signed_twin(root)
    return entry


def _signed_twin(root: Quantity) -> Quantity:
    """Return the variance behind a square root; it keeps its sign where the estimate came out below zero."""
    return replace(
        root,
        name=f"{root.name}{_TWIN}",
        title=f"{root.title}, signed variance",
        symbol=f"({root.symbol})²",
        units=tuple("1" if unit == "1" else f"{unit}^2" for unit in root.units),
        definition=f"Square of: {root.definition[0].lower()}{root.definition[1:]} May come out negative by chance.",
        signed_twin=False,
    )


def method(name: str) -> Method | None:
    """Return the definition of a method, or None where the glossary has none."""
    return next((entry for entry in METHODS if entry.name == name), None)


def flag(name: str) -> Flag | None:
    """Return the definition of a flag, or None where the glossary has none."""
    return next((entry for entry in FLAGS if entry.name == name), None)


def citations(sources: Iterable[str]) -> tuple[Reference, ...]:
    """Return the bibliography behind the ``source`` strings of rows, in its own order.

    Examples
    --------
    >>> [reference.key for reference in citations(["EMVA1288 (49)", "METHOD 3.1", "METHOD 3.1"])]
    ['METHOD', 'EMVA1288']

    """
    used = {part.split()[0] for source in sources for part in source.split(";") if part.strip()}
    return tuple(entry for entry in BIBLIOGRAPHY if entry.key in used)
