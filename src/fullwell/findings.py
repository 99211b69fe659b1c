"""What is to be said about the data: findings stand first in every report."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How much a finding matters, the worst first: ``error`` means that part of the data could not be used."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"

    @property
    def rank(self) -> int:
        """Place in any list of findings; the worst stand first."""
        return tuple(Severity).index(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One statement about the data.

    Parameters
    ----------
    code
        Stable identifier in kebab case, for example ``"no-dark-frames"``.
    severity
        ``info``, ``warning`` or ``error``.
    message
        A sentence that says what was found, and what to do where something can be done.
    files
        Paths relative to the study, in sorted order.

    """

    code: str
    severity: Severity
    message: str
    files: tuple[str, ...] = ()


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings in the order of every document: by severity, then by code."""
    return tuple(sorted(findings, key=lambda one: (one.severity.rank, one.code)))


def listed(names: Sequence[str], *, most: int = 6) -> str:
    """Return names for a sentence: the first few, and how many more there are.

    Examples
    --------
    >>> listed(["a", "b", "c"], most=2)
    'a, b and 1 more'

    """
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
