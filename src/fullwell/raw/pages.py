"""Files that hold many frames of one size: each frame is a header of its own, and a range of the file's bytes."""

from dataclasses import replace
from typing import Final

from fullwell.raw.image import Extent, RawHeader

MAX_FRAMES: Final = 100_000


def paged(whole: RawHeader, *, frames: int, offset: int, length: int, layout: object) -> tuple[RawHeader, ...]:
    """Return the headers of frames that follow one another without a gap.

    Parameters
    ----------
    whole
        What they have in common; the only header of a file of one frame.
    frames
        How many there are.
    offset, length
        Where the first begins, and bytes of each [byte].
    layout
        The layout of each, counted from its first byte.

    """
    if frames == 1:
        return (whole,)
    return tuple(
        replace(whole, page=page + 1, extent=Extent(start, start + length), layout=layout)
        for page, start in enumerate(range(offset, offset + frames * length, length))
    )
