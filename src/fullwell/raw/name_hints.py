"""What the name of a headerless file says about its pixels, as in ``Indoor1_2592x1536_8bit_GRBG.raw``.

A name is a hint, never a fact: it breaks ties between geometries that the content allows, and names the colours that
content cannot tell.
"""

import re
from dataclasses import dataclass
from typing import Final

from fullwell.raw.cfa import BAYER, MONO

_SIZE: Final = re.compile(r"(?<!\d)(\d{2,5})\s*[x×]\s*(\d{2,5})(?!\d)", re.IGNORECASE)
_BITS: Final = re.compile(r"(?<!\d)(\d{1,2})[ _-]?bits?(?![a-z])", re.IGNORECASE)
_CFA: Final = re.compile(rf"(?<![a-z])({'|'.join((*BAYER, MONO))})(?![a-z])", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class NameHints:
    """What a name says; None where it does not.

    Parameters
    ----------
    size
        Width and height [pixel].
    bits
        Bits of a sample, 1 to 16.
    cfa
        ``RGGB``, ``GRBG``, ``GBRG``, ``BGGR`` or ``mono``.

    """

    size: tuple[int, int] | None = None
    bits: int | None = None
    cfa: str | None = None


def hints_in(name: str) -> NameHints:
    """Return what a file's name says.

    Examples
    --------
    >>> hints_in("Indoor1_2592x1536_8bit_GRBG.raw")
    NameHints(size=(2592, 1536), bits=8, cfa='GRBG')
    >>> hints_in("DSC_1339.raw")
    NameHints(size=None, bits=None, cfa=None)

    """
    size, bits, cfa = _SIZE.search(name), _BITS.search(name), _CFA.search(name)
    known = {one.casefold(): one for one in (*BAYER, MONO)}
    return NameHints(
        size=(int(size[1]), int(size[2])) if size else None,
        bits=int(bits[1]) if bits and 1 <= int(bits[1]) <= 16 else None,
        cfa=known[cfa[1].casefold()] if cfa else None,
    )
