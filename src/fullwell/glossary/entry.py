"""What the glossary is made of: a quantity, a method, a flag, a source."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """One figure of merit, defined.

    Parameters
    ----------
    name
        Name of the rows, as in results.json.
    title
        What people call it.
    symbol
        Symbol of the equation.
    units
        Units it is given in, the native one first.
    definition
        One sentence or two that say what it is.
    equation
        How it follows from what is measured, symbols as in ``symbol``.
    source
        Citation key and section or equation, for example ``"METHOD 3.1"``.
    signed_twin
        Whether it is the square root of an estimated variance, so that ``<name>_variance`` stands beside it.

    """

    name: str
    title: str
    symbol: str
    units: tuple[str, ...]
    definition: str
    equation: str
    source: str
    signed_twin: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Method:
    """One estimator: what it does and, where it is kept only because it was published, how it is biased."""

    name: str
    definition: str
    source: str
    bias: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flag:
    """What a flag on a row tells."""

    name: str
    definition: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """One entry of the bibliography; ``key`` is the first word of a row's ``source``."""

    key: str
    text: str
