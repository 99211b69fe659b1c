"""Colours of values: tables from the lowest to the highest, and shades between given colours.

Viridis is by S. van der Walt, N. Smith and E. Firing (CC0), here every fifth of its 256 colours; red to blue is the
scheme RdBu of C. Brewer's ColorBrewer 2.0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_VIRIDIS: Final = (
    "440154 46085c 471063 481769 481d6f 482475 472a7a 46307e 453781 433d84 414287 3f4889 3d4e8a "
    "3a538b 38598c 355e8d 33638d 31688e 2e6d8e 2c718e 2a768e 297b8e 27808e 25848e 23898e 218e8d "
    "20928c 1f978b 1e9c89 1fa188 21a585 24aa83 28ae80 2eb37c 35b779 3dbc74 46c06f 50c46a 5ac864 "
    "65cb5e 70cf57 7cd250 89d548 95d840 a2da37 b0dd2f bddf26 cae11f d8e219 e5e419 f1e51d fde725"
)
_BLUE_TO_RED: Final = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Colors:
    """A table of colours, shape (colours, 3)."""

    table: NDArray[np.uint8]

    def at(self, shares: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return the colours of shares, 0 to 1, shape (..., 3)."""
        last = len(self.table) - 1
        return self.table[np.clip(np.floor(shares * (last + 1)), 0, last).astype(np.intp)]


def rgb(color: str) -> NDArray[np.uint8]:
    """Return red, green and blue of a colour.

    Examples
    --------
    >>> rgb("#ff8000").tolist()
    [255, 128, 0]

    """
    return np.frombuffer(bytes.fromhex(color.removeprefix("#")), np.uint8)


def hexadecimal(color: Sequence[int]) -> str:
    """Return a colour by its red, green and blue.

    Examples
    --------
    >>> hexadecimal((255, 128, 0))
    '#ff8000'

    """
    return "#" + "".join(f"{part:02x}" for part in color)


def shades(*colors: str, count: int = 256) -> Colors:
    """Return colours that go evenly from one to the next.

    Parameters
    ----------
    colors
        Two at least.
    count
        How many colours.

    """
    given = np.array([rgb(color) for color in colors], float)
    places = np.linspace(0.0, len(colors) - 1.0, count)
    parts = [np.interp(places, np.arange(len(colors)), given[:, part]) for part in range(3)]
    return Colors(table=np.column_stack(parts).round().astype(np.uint8))


VIRIDIS: Final = shades(*_VIRIDIS.split())
DIVERGING: Final = shades(*_BLUE_TO_RED.split())
"""Blue below, red above what is neither."""
GRAYS: Final = shades("#000000", "#ffffff")
