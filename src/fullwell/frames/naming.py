"""ISO and exposure from the names of files and folders, for files that carry no metadata (RESULTS 1).

``ISO_<n>`` and ``exp<number>(us|ms|s)`` are understood without regard to case; ``_``, ``-`` or a blank may stand
between word and number. The file's own name comes first, then its folder, then the folder's folder.
"""

import re
from collections.abc import Callable, Sequence
from pathlib import PurePosixPath
from typing import Final

_ISO: Final = re.compile(r"(?<![a-z])iso[_\- ]?(\d+)(?!\d)", re.IGNORECASE)
_EXPOSURE: Final = re.compile(
    r"(?<![a-z])exp(?:osure)?[_\- ]?(\d+(?:\.\d+)?|\.\d+)[_\- ]?(us|µs|ms|s)(?![a-z])", re.IGNORECASE
)
PER_SECOND: Final = {"us": 1e6, "µs": 1e6, "ms": 1e3, "s": 1.0}


def iso_in_name(name: str) -> float | None:
    """Return the ISO a name holds, None where it holds none or zero.

    Examples
    --------
    >>> iso_in_name("ISO_55")
    55.0
    >>> iso_in_name("isolated_5") is None
    True

    """
    match = _ISO.search(name)
    return (float(match[1]) or None) if match else None


def exposure_in_name(name: str) -> float | None:
    """Return the exposure a name holds [s], None where it holds none or zero.

    Examples
    --------
    >>> exposure_in_name("exp000002867us_n03.tiff")
    0.002867
    >>> exposure_in_name("EXP_0.5s")
    0.5

    """
    match = _EXPOSURE.search(name)
    return (float(match[1]) / PER_SECOND[match[2].lower()] or None) if match else None


def iso_in_path(name: str) -> float | None:
    """Return the ISO of the innermost part of a relative path that holds one."""
    return _innermost(iso_in_name, name)


def exposure_in_path(name: str) -> float | None:
    """Return the exposure of the innermost part of a relative path that holds one [s]."""
    return _innermost(exposure_in_name, name)


def _innermost(reading: Callable[[str], float | None], name: str) -> float | None:
    parts: Sequence[str] = PurePosixPath(name).parts
    return next((found for part in reversed(parts) if (found := reading(part)) is not None), None)
