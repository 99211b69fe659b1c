"""What is said of pixels that stand alone."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.findings import Finding, Severity
from fullwell.statistics.isolated_pixels import IsolatedPixels

NOTABLE_SHARE: Final = 5e-5
"""Of the pixels that may stand alone by chance, with skewed noise or glints of light."""
NOTABLE: Final = 4
MOST_LISTED: Final = 3


def isolated_findings(isolated: IsolatedPixels, mosaic: NDArray[np.uint16]) -> tuple[Finding, ...]:
    """Return a finding where more pixels stand alone than chance and glints leave."""
    count = len(isolated.above) + len(isolated.below)
    if count <= NOTABLE + NOTABLE_SHARE * mosaic.size:
        return ()
    parts = [
        f"{len(places)} far {side} ({_first(places, mosaic)})"
        for side, places in (("above", isolated.above), ("below", isolated.below))
        if len(places)
    ]
    message = (
        f"{count} pixels ({100.0 * count / mosaic.size:.2g} %) stand alone among neighbours of their colour: "
        f"{' and '.join(parts)}. Hot, dead or stuck pixels, or planted ones; they count in fixed pattern and in the "
        "extreme codes."
    )
    return (Finding(code="isolated-pixels", severity=Severity.INFO, message=message),)


def _first(places: NDArray[np.int64], mosaic: NDArray[np.uint16]) -> str:
    shown = [f"row {row} column {column}: {mosaic[row, column]} DN" for row, column in places[:MOST_LISTED].tolist()]
    more = ["..."] if len(places) > MOST_LISTED else []
    return "; ".join([*shown, *more])
