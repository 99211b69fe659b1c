"""Mean and variance of a burst, pixel by pixel."""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fullwell.kernels.moments_summary import map_rows
from fullwell.kernels.stack import Stack


def burst_maps(
    frames: NDArray[np.uint16], *, workers: int = 1, out: NDArray[np.float32] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the mean and the unbiased variance over frames of each pixel.

    Sums are exact; each result is rounded to float32 at the end.

    Parameters
    ----------
    frames
        Shape (frames, height, width), at most 65536 frames [DN].
    workers
        Threads; the maps do not depend on their number.
    out
        Memory for both maps, shape (2, height, width), to be used again burst after burst; None takes new memory.

    Returns
    -------
    tuple
        Two maps of shape (height, width) [DN] and [DN^2]; the variance of a single frame is NaN.

    Examples
    --------
    >>> mean, variance = burst_maps(np.array([[[1]], [[3]]], dtype=np.uint16))
    >>> float(mean[0, 0]), float(variance[0, 0])
    (2.0, 2.0)

    """
    count, height, width = frames.shape
    if not 0 < count <= 65536:
        raise ValueError(f"a burst has 1 to 65536 frames, not {count}")
    codes = np.ascontiguousarray(frames, dtype=np.uint16).reshape(-1)
    codes.flags.writeable = False
    stack = Stack(codes, np.arange(count, dtype=np.int64) * (height * width), width)
    mean, variance = np.empty((2, height, width), np.float32) if out is None else out
    edges = [height * k // workers for k in range(workers + 1)]
    if workers == 1:
        map_rows(stack, (0, height), mean, variance)
        return mean, variance
    with ThreadPoolExecutor(workers) as pool:
        for part in [pool.submit(map_rows, stack, rows, mean, variance) for rows in pairwise(edges)]:
            part.result()
    return mean, variance
