"""DNG opcode lists: what a reader of the file is to do to its image (DNG 1.4, chapter 7).

Opcode lists are big-endian whatever the byte order of the file. `GainMap`, the opcode of lens shading, is typed; every
other opcode keeps its parameters as the bytes they are, so that a list can be read, changed and written without loss.

Which list: the first works on stored codes, the second on linear values with black subtracted, where shading belongs,
the third on the demosaicked image.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UnreadableFileError
from fullwell.raw.cfa import cell

GAIN_MAP_ID: Final = 9
_DNG_1_3: Final = 0x01030000
_OPTIONAL: Final = 1
_HEAD: Final = struct.Struct(">IIII")
_MAP: Final = struct.Struct(">10I4dI")


class OpcodeList(IntEnum):
    """Tags of the three lists."""

    OPCODE_LIST_1 = 51008
    OPCODE_LIST_2 = 51009
    OPCODE_LIST_3 = 51022


@dataclass(frozen=True, slots=True, kw_only=True)
class Opcode:
    """An opcode as the file has it.

    Parameters
    ----------
    id
        What it does: `GAIN_MAP_ID` for a gain map.
    version
        First DNG version that defines it, one byte a number.
    flags
        Bit 0: a reader that does not know it may leave it out. Bit 1: it may be left out of a preview.
    data
        Its parameters, big-endian.

    """

    id: int
    version: int
    flags: int
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GainMap:
    """The DNG opcode GainMap: a coarse grid of factors, interpolated linearly between its points.

    Places on the grid are fractions of the active area: pixel ``row`` of ``height`` lies at ``(row + 0.5) / height``,
    and grid point ``v`` at ``origin_v + v * spacing_v``; beyond the grid its edge goes on.

    Parameters
    ----------
    top, left, bottom, right
        Pixels that are multiplied, in the active area.
    plane, planes
        First colour plane, and how many; 0 and 1 for a mosaic.
    row_pitch, column_pitch
        Every how many-th row and column, counted from ``top`` and ``left``: 2 for one site of a Bayer mosaic.
    spacing_v, spacing_h, origin_v, origin_h
        Of the grid, relative to the height and width of the active area [1].
    values
        Factors, shape (V, H, map planes), float32 [1].
    version, flags
        As in `Opcode`; optional by default.

    """

    top: int
    left: int
    bottom: int
    right: int
    plane: int = 0
    planes: int = 1
    row_pitch: int = 1
    column_pitch: int = 1
    spacing_v: float
    spacing_h: float
    origin_v: float = 0.0
    origin_h: float = 0.0
    values: NDArray[np.float32]
    version: int = _DNG_1_3
    flags: int = _OPTIONAL

    def at(self, rows: NDArray[np.int64], columns: NDArray[np.int64], *, size: tuple[int, int]) -> NDArray[np.float64]:
        """Return the factors at the outer product of pixel rows and columns of an active area.

        Parameters
        ----------
        rows, columns
            In the active area, shapes (R,) and (C,).
        size
            Height and width of the active area [pixel].

        Returns
        -------
        ndarray
            Shape (R, C, map planes) [1].

        """
        down = _linear(
            (rows + 0.5) / size[0], origin=self.origin_v, spacing=self.spacing_v, points=self.values.shape[0]
        )
        across = _linear(
            (columns + 0.5) / size[1], origin=self.origin_h, spacing=self.spacing_h, points=self.values.shape[1]
        )
        grid = self.values.astype(np.float64)
        return np.stack([down @ grid[:, :, plane] @ across.T for plane in range(grid.shape[2])], axis=2)


def _linear(places: NDArray[np.float64], *, origin: float, spacing: float, points: int) -> NDArray[np.float64]:
    """Return the matrix of linear interpolation between evenly spaced points, shape (places, points)."""
    steps = np.zeros_like(places) if points == 1 else np.clip((places - origin) / spacing, 0.0, points - 1.0)
    return np.maximum(0.0, 1.0 - np.abs(steps[:, None] - np.arange(points)))


def parse_opcodes(data: bytes) -> tuple[Opcode | GainMap, ...]:
    """Return the opcodes of a list, in their order.

    Parameters
    ----------
    data
        Value of the tag OpcodeList1, 2 or 3; empty where the file has none.

    Raises
    ------
    UnreadableFileError
        ``file-damaged`` where the list is cut off or contradicts itself.

    """
    if not data:
        return ()
    found: list[Opcode | GainMap] = []
    try:
        (count,) = struct.unpack_from(">I", data)
        position = 4
        for _ in range(count):
            identifier, version, flags, size = _HEAD.unpack_from(data, position)
            position += _HEAD.size
            if position + size > len(data):
                raise _damaged()
            opcode = Opcode(id=identifier, version=version, flags=flags, data=data[position : position + size])
            found.append(_gain_map(opcode) if identifier == GAIN_MAP_ID else opcode)
            position += size
    except struct.error as error:
        raise _damaged() from error
    return tuple(found)


def opcode_bytes(opcodes: Sequence[Opcode | GainMap]) -> bytes:
    """Return an opcode list as a DNG file has it."""
    plain = [_as_opcode(one) if isinstance(one, GainMap) else one for one in opcodes]
    heads = (_HEAD.pack(one.id, one.version, one.flags, len(one.data)) + one.data for one in plain)
    return struct.pack(">I", len(plain)) + b"".join(heads)


def mosaic_gain_maps(values: NDArray[np.floating], *, cfa: str, size: tuple[int, int]) -> tuple[GainMap, ...]:
    """Return one gain map per CFA site, all on a grid that reaches from edge to edge of the active area.

    Parameters
    ----------
    values
        Factors, shape (sites, V, H), sites row-major; point (v, h) stands at v/(V - 1) of the height and h/(H - 1) of
        the width, see `gain_map_places` [1].
    cfa
        Order at the visible top-left pixel.
    size
        Height and width of the active area [pixel].

    """
    period = cell(cfa)
    _sites, down, across = values.shape
    return tuple(
        GainMap(
            top=site // period,
            left=site % period,
            bottom=size[0],
            right=size[1],
            row_pitch=period,
            column_pitch=period,
            spacing_v=1.0 / max(down - 1, 1),
            spacing_h=1.0 / max(across - 1, 1),
            values=np.asarray(one, dtype=np.float32)[:, :, np.newaxis],
        )
        for site, one in enumerate(values)
    )


def gain_map_places(points: int, length: int) -> NDArray[np.float64]:
    """Return where the points of `mosaic_gain_maps` stand along a side, in pixels counted from 0.

    Examples
    --------
    >>> gain_map_places(3, 100).tolist()
    [-0.5, 49.5, 99.5]

    """
    return np.linspace(0.0, 1.0, points) * length - 0.5


def _gain_map(opcode: Opcode) -> GainMap:
    numbers = _MAP.unpack_from(opcode.data)
    top, left, bottom, right, plane, planes, row_pitch, column_pitch, down, across = numbers[:10]
    spacing_v, spacing_h, origin_v, origin_h, map_planes = numbers[10:]
    count = down * across * map_planes
    placed = min(row_pitch, column_pitch, planes, count) > 0 and top <= bottom and left <= right
    if not placed or len(opcode.data) != _MAP.size + 4 * count:
        raise _damaged()
    spaced = np.isfinite((spacing_v, spacing_h, origin_v, origin_h)).all()
    if not spaced or (spacing_v <= 0.0 and down > 1) or (spacing_h <= 0.0 and across > 1):
        raise _damaged()
    values = np.frombuffer(opcode.data, dtype=">f4", offset=_MAP.size).astype(np.float32)
    return GainMap(
        top=top,
        left=left,
        bottom=bottom,
        right=right,
        plane=plane,
        planes=planes,
        row_pitch=row_pitch,
        column_pitch=column_pitch,
        spacing_v=spacing_v,
        spacing_h=spacing_h,
        origin_v=origin_v,
        origin_h=origin_h,
        values=values.reshape(down, across, map_planes),
        version=opcode.version,
        flags=opcode.flags,
    )


def _as_opcode(one: GainMap) -> Opcode:
    down, across, map_planes = one.values.shape
    area = (one.top, one.left, one.bottom, one.right, one.plane, one.planes, one.row_pitch, one.column_pitch)
    grid = (one.spacing_v, one.spacing_h, one.origin_v, one.origin_h)
    data = _MAP.pack(*area, down, across, *grid, map_planes) + one.values.astype(">f4").tobytes()
    return Opcode(id=GAIN_MAP_ID, version=one.version, flags=one.flags, data=data)


def _damaged() -> UnreadableFileError:
    return UnreadableFileError("file-damaged", "an opcode list is damaged or cut off; copy the file again")
