"""Memory as the system likes it: what is used again and again in large pages, and what is freed given back.

The C library would keep much of what is freed, for arrays that never come. Only the GNU C library is spoken to;
elsewhere nothing happens.
"""

import ctypes
import sys
from typing import Final

import numpy as np
from numpy.typing import NDArray

_TRIM_THRESHOLD: Final = -1
_MMAP_THRESHOLD: Final = -3
_LARGE: Final = 4_000_000
"""From where on memory is asked of the system and given back to it one by one [byte]."""
_LARGE_PAGE: Final = 1 << 21
"""[byte]"""


def in_large_pages(size: int) -> NDArray[np.uint8]:
    """Return memory that begins where a large page does, which NumPy asks the system for from 4 MiB on [byte]."""
    memory = np.empty(max(size + _LARGE_PAGE, 2 * _LARGE_PAGE), np.uint8)
    skipped = -int(memory.__array_interface__["data"][0]) % _LARGE_PAGE
    return memory[skipped : skipped + size]


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
