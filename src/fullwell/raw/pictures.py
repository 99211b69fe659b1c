"""PNG and JPEG XL as their libraries decode them, in the process of the decoders (`fullwell.raw.isolation`)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError

Answer = tuple[Mapping[str, Any], NDArray[np.uint16]]


def decode_png_pixels(data: bytes, *, shape: list[int]) -> Answer:
    """Return a PNG file's pixels, of exactly this shape.

    Raises
    ------
    UnreadableFileError
        ``file-damaged``.

    """
    from imagecodecs import png_decode  # noqa: PLC0415 - loads when used

    return {}, _shaped(np.asarray(png_decode(data)), shape, "PNG")


def decode_jpeg_xl(data: bytes, *, shape: list[int]) -> Answer:
    """Return the pixels of a JPEG XL codestream, of exactly this shape.

    Raises
    ------
    UnreadableFileError
        ``file-damaged``.

    """
    from imagecodecs import jpegxl_decode  # noqa: PLC0415 - loads when used

    return {}, _shaped(np.asarray(jpegxl_decode(data)), shape, "JPEG XL")


def _shaped(pixels: NDArray[Any], shape: list[int], name: str) -> NDArray[np.uint16]:
    plain = pixels[..., 0] if pixels.ndim == 3 and pixels.shape[2] == 1 else pixels
    if plain.shape != tuple(shape) or plain.dtype.kind != "u" or plain.dtype.itemsize > 2:
        raise UnreadableFileError("file-damaged", f"the {name} pixels are not the size its header says")
    return plain.astype(np.uint16)
