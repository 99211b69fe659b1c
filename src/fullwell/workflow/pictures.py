"""Pictures of two unlit frames, for the report only: no figure is measured here."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import RawFileError
from fullwell.frames.series import Frame
from fullwell.raw.open import decode, read_bytes
from fullwell.report.pictures import DarkZoom, DifferencePicture, Pictures, RegionHistogram
from fullwell.statistics.first_look import middle
from fullwell.workflow.measure.bursts import Burst, IsoBursts
from fullwell.workflow.measure.read_noise import choose_burst

MAX_EDGE = 768
ZOOM = 64
REGION = 128


def take_pictures(group: IsoBursts) -> Pictures:
    """Return the difference of two unlit frames of an ISO, and a magnified piece of the first; empty without them."""
    burst = choose_burst(group)
    if burst is None:
        return Pictures()
    frames = [frame for frame in burst.series.frames if frame.name in burst.statistics.frames][:2]
    try:
        first, second = _middles(burst, frames)
    except (RawFileError, OSError):
        return Pictures()
    difference = first - second
    height, width = difference.shape
    top, left = (_start(size, MAX_EDGE) for size in (height, width))
    crop = difference[top : top + MAX_EDGE, left : left + MAX_EDGE]
    zoom_top, zoom_left = (_start(size, ZOOM) for size in (height, width))
    zoom = first[zoom_top : zoom_top + ZOOM, zoom_left : zoom_left + ZOOM]
    return Pictures(
        differences=(
            DifferencePicture(
                iso=group.iso,
                frames=(frames[0].name, frames[1].name),
                image=crop.astype(np.int16),
                regions=tuple(_regions(crop)),
            ),
        ),
        dark_zooms=(
            DarkZoom(
                iso=group.iso,
                image=(zoom - zoom.mean()).astype(np.float32),
                title=f"{ZOOM} x {ZOOM} pixels at the centre of {frames[0].name}, mean removed",
            ),
        ),
    )


def _middles(burst: Burst, frames: Sequence[Frame]) -> Iterable[NDArray[np.int32]]:
    """Yield the middles of two frames, which are read again where nobody kept them."""
    known = burst.first
    if known is not None and known.middles is not None and known.frames[:2] == tuple(frame.name for frame in frames):
        yield from known.middles.astype(np.int32)
        return
    for frame in frames:
        mosaic = decode(frame.header, read_bytes(frame.header))
        yield mosaic[middle(mosaic.shape, burst.cell)].astype(np.int32)


def _start(size: int, edge: int) -> int:
    """Return where a centred piece starts, on an even pixel so that its CFA phase is the mosaic's."""
    return max(0, (size - edge) // 2) // 2 * 2


def _regions(crop: NDArray[np.int32]) -> Iterable[RegionHistogram]:
    height, width = crop.shape
    edge = min(REGION, height, width)
    corners = {
        "top left": (0, 0),
        "top right": (0, width - edge),
        "centre": ((height - edge) // 2, (width - edge) // 2),
        "bottom right": (height - edge, width - edge),
    }
    for name, (top, left) in corners.items():
        region = crop[top : top + edge, left : left + edge]
        codes, counts = np.unique(region, return_counts=True)
        yield RegionHistogram(
            name=name,
            x=left,
            y=top,
            width=edge,
            height=edge,
            codes=codes.astype(np.int64),
            counts=counts.astype(np.int64),
            std_dn=float(region.std(ddof=1)),
        )
