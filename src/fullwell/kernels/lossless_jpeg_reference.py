"""What `lossless_jpeg` decodes, as annex H of ITU-T T.81 tells it: to read, and to test the compiled loops against."""

import numpy as np
from numpy.typing import NDArray


def decode_scan_plain(
    data: bytes,
    tables: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...],
    *,
    width: int,
    height: int,
    start_value: int,
    predictor: int,
    shift: int,
) -> NDArray[np.uint16]:
    """Do what `lossless_jpeg.decode_lines` does, one sample at a time, for whole scans, with their point transform."""
    coded = data.replace(b"\xff\x00", b"\xff")
    bits = "".join(f"{byte:08b}" for byte in coded)
    codes = [_codes(counts, categories) for counts, categories in tables]
    samples = np.zeros((height, width, len(tables)), dtype=np.int64)
    position = 0
    for line, column, component in np.ndindex(*samples.shape):
        length = next(n for n in range(1, 17) if bits[position : position + n] in codes[component])
        category = codes[component][bits[position : position + length]]
        position += length
        additional = bits[position : position + category] if category < 16 else ""
        position += len(additional)
        difference = _extended(additional) if category < 16 else 32768
        seen = samples[:, :, component]
        if line == 0:
            predicted = start_value if column == 0 else seen[0, column - 1]
        elif column == 0:
            predicted = seen[line - 1, 0]
        else:
            left, above, corner = seen[line, column - 1], seen[line - 1, column], seen[line - 1, column - 1]
            predicted = (
                left,
                above,
                corner,
                left + above - corner,
                left + ((above - corner) >> 1),
                above + ((left - corner) >> 1),
                (left + above) >> 1,
            )[predictor - 1]
        samples[line, column, component] = (predicted + difference) % 65536
    return (samples << shift).astype(np.uint16).reshape(height, -1)


def _codes(counts: tuple[int, ...], categories: tuple[int, ...]) -> dict[str, int]:
    """Return the category of each code, codes written as text (T.81, C.2)."""
    remaining = iter(categories)
    codes: dict[str, int] = {}
    code = 0
    for length, count in enumerate(counts, start=1):
        for _ in range(count):
            codes[f"{code:0{length}b}"] = next(remaining)
            code += 1
        code <<= 1
    return codes


def _extended(bits: str) -> int:
    """Return the difference that additional bits stand for (T.81, F.2.2.1 EXTEND).

    Examples
    --------
    >>> [_extended(bits) for bits in ("", "00", "01", "10", "11")]
    [0, -3, -2, 2, 3]

    """
    if not bits:
        return 0
    return int(bits, 2) if bits[0] == "1" else int(bits, 2) - (1 << len(bits)) + 1
