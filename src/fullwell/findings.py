"""What is to be said about the data: findings stand first in every report."""

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """How much a finding matters: an ``error`` means that part of the data could not be used."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


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
