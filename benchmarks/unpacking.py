"""Unpacking MIPI RAW12 against the array expressions that anybody would write with NumPy."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.studies import HEIGHT, WIDTH
from benchmarks.timing import REPEATS, Comparison, medians
from fullwell.kernels.unpacking_mipi import mipi_row_bytes, unpack_mipi_rows

NAME = "NumPy / unpacking MIPI RAW12 of 12 MP, one thread each"
BITS = 12


def with_numpy(packed: NDArray[np.uint8], out: NDArray[np.uint16]) -> None:
    """Unpack two samples from three bytes, whole images at a time."""
    first, second, low = (packed[byte::3].astype(np.uint16) for byte in range(3))
    pairs = out.reshape(-1, 2)
    pairs[:, 0] = first << 4 | low & 15
    pairs[:, 1] = second << 4 | low >> 4


def against_numpy() -> list[Comparison]:
    """Compare one frame, to the same memory every time."""
    row_bytes = mipi_row_bytes(WIDTH, bits=BITS)
    packed = np.random.default_rng(0).integers(0, 256, HEIGHT * row_bytes, dtype=np.uint8)
    ours, theirs = (np.empty((HEIGHT, WIDTH), np.uint16) for _ in range(2))
    times = medians(
        {
            "numpy": lambda: with_numpy(packed, theirs),
            "ours": lambda: unpack_mipi_rows(packed, ours, bits=BITS, row_bytes=row_bytes),
        },
        repeats=2 * REPEATS,
    )
    if not np.array_equal(ours, theirs):
        raise RuntimeError("NumPy unpacked something else")
    detail = f"{times['numpy'] * 1e3:.1f} ms against {times['ours'] * 1e3:.1f} ms"
    return [Comparison(name=NAME, value=times["numpy"] / times["ours"], target=3.0, at_least=True, detail=detail)]
