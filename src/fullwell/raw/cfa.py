"""Colour-filter arrays: which pixel belongs to which plane.

A CFA is named by its order at the visible top-left pixel: ``RGGB``, ``GRBG``, ``GBRG``, ``BGGR``, or ``mono``.
A *site* is a position in the repeating 2 x 2 cell, row-major; a *channel* is ``R``, ``G1`` (green in the red rows),
``G2``, ``B``, or ``mono``. Statistics are kept by site; results are named by channel.
"""

from collections.abc import Iterable
from typing import Final

BAYER: Final = ("RGGB", "GRBG", "GBRG", "BGGR")
MONO: Final = "mono"
CHANNELS: Final = ("R", "G1", "G2", "B")
ALL: Final = "all"
"""What rows call a figure that the channels share."""
_ORDER: Final = (*CHANNELS, MONO, "G", ALL)
_LEADING: Final = (ALL, MONO, "G1")


def cell(cfa: str) -> int:
    """Return the period of the pattern in pixels: 2 for Bayer, 1 for mono."""
    return 1 if cfa == MONO else 2


def channels(cfa: str) -> tuple[str, ...]:
    """Return the channel of each site, row-major.

    Examples
    --------
    >>> channels("BGGR")
    ('B', 'G2', 'G1', 'R')
    >>> channels("mono")
    ('mono',)

    """
    if cfa == MONO:
        return (MONO,)
    named: list[str] = []
    for site, letter in enumerate(cfa):
        row = cfa[site // 2 * 2 : site // 2 * 2 + 2]
        named.append(letter if letter != "G" else ("G1" if "R" in row else "G2"))
    return tuple(named)


def channel_rank(channel: str) -> int:
    """Return where a channel stands in legends and tables; channels by another name stand last."""
    return _ORDER.index(channel) if channel in _ORDER else len(_ORDER)


def leading_channel(channels: Iterable[str]) -> str:
    """Return the channel that speaks for the others: the figure they share, else G1, else the first.

    Examples
    --------
    >>> leading_channel(["R", "G1", "all"]), leading_channel(["B", "R"])
    ('all', 'R')

    """
    return min(channels, key=lambda name: (_LEADING.index(name) if name in _LEADING else 3, channel_rank(name)))


def shifted(cfa: str, *, rows: int, columns: int) -> str:
    """Return the order seen from a pixel ``rows`` down and ``columns`` to the right.

    Examples
    --------
    >>> shifted("RGGB", rows=1, columns=0)
    'GBRG'
    >>> shifted("RGGB", rows=26, columns=152)
    'RGGB'

    """
    if cfa == MONO:
        return cfa
    return "".join(cfa[(site // 2 + rows) % 2 * 2 + (site + columns) % 2] for site in range(4))
