"""Freed memory goes back to the system: the C library would keep much of it, for arrays that never come.

Only the GNU C library is spoken to; elsewhere nothing happens.
"""

import ctypes
import sys
from typing import Final

_TRIM_THRESHOLD: Final = -1
_MMAP_THRESHOLD: Final = -3
_LARGE: Final = 4_000_000
"""From where on memory is asked of the system and given back to it one by one [byte]."""


def keep_large_apart() -> None:
    """Have large arrays lie in memory of their own, which goes back as soon as they are let go."""
    library = _library()
    if library is not None:
        library.mallopt(_MMAP_THRESHOLD, _LARGE)
        library.mallopt(_TRIM_THRESHOLD, 4 * _LARGE)


def give_back() -> None:
    """Give back what is free between what is in use."""
    library = _library()
    if library is not None:
        library.malloc_trim(0)


def _library() -> ctypes.CDLL | None:
    library = ctypes.CDLL(None) if sys.platform == "linux" else None
    return library if hasattr(library, "malloc_trim") else None
