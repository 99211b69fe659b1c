"""A TrueType font as it is needed to set a line: widths, kerning, outlines. Nothing is read before it is asked for."""

import struct
from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

Point: TypeAlias = tuple[float, float, bool]
"""x and y in font units, and whether the outline goes through it or bends towards it."""

_MISSING: Final = 0
_WORDS, _OFFSETS, _SCALE, _MORE, _TWO_SCALES, _MATRIX = 0x01, 0x02, 0x08, 0x20, 0x40, 0x80
"""Flags of a part of a composite glyph."""
_ON_CURVE, _SHORT_X, _SHORT_Y, _REPEATED, _SAME_X, _SAME_Y = 0x01, 0x02, 0x04, 0x08, 0x10, 0x20
"""Flags of a point."""


class Face:
    """A font with outlines of quadratic curves and a character table of format 4.

    Parameters
    ----------
    path
        Its file.

    """

    def __init__(self, path: Path) -> None:
        self._data = path.read_bytes()
        count = struct.unpack_from(">H", self._data, 4)[0]
        self._tables: Mapping[bytes, int] = {
            tag: offset for tag, _, offset, _ in struct.iter_unpack(">4sIII", self._data[12 : 12 + 16 * count])
        }
        self.units: int = self._numbers("head", 18, "H")[0]
        """Font units of an em."""

    def glyph(self, character: str) -> int:
        """Return the number of the glyph of a character: 0, an empty box, where the font has none."""
        return self._glyphs.get(ord(character), _MISSING)

    def advance(self, glyph: int) -> int:
        """Return how far the next glyph stands from this one [font unit]."""
        return int(self._advances[min(glyph, len(self._advances) - 1)])

    def kerning(self, left: int, right: int) -> int:
        """Return how much farther apart than that two glyphs stand [font unit]."""
        return self._kerning.get(left << 16 | right, 0)

    @lru_cache(maxsize=1024)  # noqa: B019 - a face lives as long as the process
    def outline(self, glyph: int) -> str:
        """Return the outline of a glyph as an SVG path, y upwards [font unit]."""
        return "".join(_contour(points) for points in self._contours(glyph))

    def _numbers(self, table: str, offset: int, kind: str) -> tuple[int, ...]:
        return struct.unpack_from(f">{kind}", self._data, self._tables[table.encode()] + offset)

    def _array(self, kind: str, count: int, offset: int) -> np.ndarray:
        return np.frombuffer(self._data, np.dtype(kind), count, offset)

    @cached_property
    def _glyphs(self) -> Mapping[int, int]:
        table = self._tables[b"cmap"]
        for record in range(self._numbers("cmap", 2, "H")[0]):
            offset = table + struct.unpack_from(">HHI", self._data, table + 4 + 8 * record)[2]
            if struct.unpack_from(">H", self._data, offset)[0] == 4:
                return dict(self._mapped(offset))
        return {}

    def _mapped(self, offset: int) -> Iterator[tuple[int, int]]:
        """Yield code points with their glyphs from a character table of format 4."""
        count = struct.unpack_from(">H", self._data, offset + 6)[0] // 2
        ends = self._array(">u2", count, offset + 14)
        starts = self._array(">u2", count, offset + 16 + 2 * count)
        deltas = self._array(">u2", count, offset + 16 + 4 * count)
        ranges = offset + 16 + 6 * count
        for segment, (start, end, delta) in enumerate(zip(*(a.tolist() for a in (starts, ends, deltas)), strict=True)):
            place = ranges + 2 * segment
            aside = struct.unpack_from(">H", self._data, place)[0]
            for code in range(start, min(end, 0xFFFE) + 1):
                glyph = code
                if aside:
                    glyph = struct.unpack_from(">H", self._data, place + aside + 2 * (code - start))[0]
                if glyph or not aside:
                    yield code, (glyph + delta) & 0xFFFF

    @cached_property
    def _advances(self) -> np.ndarray:
        count = self._numbers("hhea", 34, "H")[0]
        return self._array(">u2", 2 * count, self._tables[b"hmtx"])[::2]

    @cached_property
    def _kerning(self) -> Mapping[int, int]:
        """Return the kerning by pairs of glyphs, from the first subtable, of format 0."""
        if b"kern" not in self._tables:
            return {}
        table = self._tables[b"kern"]
        count = self._numbers("kern", 10, "H")[0]
        pairs = self._array(">u2", 3 * count, table + 18).reshape(count, 3).astype(np.int64)
        keys = pairs[:, 0] << 16 | pairs[:, 1]
        return dict(zip(keys.tolist(), pairs[:, 2].astype(np.int16).tolist(), strict=True))

    @cached_property
    def _places(self) -> np.ndarray:
        count = self._numbers("maxp", 4, "H")[0] + 1
        long = self._numbers("head", 50, "h")[0] == 1
        places = self._array(">u4" if long else ">u2", count, self._tables[b"loca"]).astype(np.int64)
        return self._tables[b"glyf"] + (places if long else 2 * places)

    def _contours(self, glyph: int) -> list[list[Point]]:
        start, end = self._places[glyph : glyph + 2].tolist()
        if start == end:
            return []
        count = struct.unpack_from(">h", self._data, start)[0]
        return self._simple(start + 10, count) if count >= 0 else self._composite(start + 10)

    def _simple(self, at: int, count: int) -> list[list[Point]]:
        ends = struct.unpack_from(f">{count}H", self._data, at)
        at += 2 * count
        at += 2 + struct.unpack_from(">H", self._data, at)[0]
        flags: list[int] = []
        while len(flags) <= ends[-1]:
            flag = self._data[at]
            times = 1 + (self._data[at + 1] if flag & _REPEATED else 0)
            at += 2 if flag & _REPEATED else 1
            flags += [flag] * times
        x, at = self._coordinates(at, flags, _SHORT_X, _SAME_X)
        y, at = self._coordinates(at, flags, _SHORT_Y, _SAME_Y)
        points = [(a, b, bool(flag & _ON_CURVE)) for a, b, flag in zip(x, y, flags, strict=True)]
        starts = [0, *(end + 1 for end in ends)]
        return [points[start : end + 1] for start, end in zip(starts, ends, strict=False)]

    def _coordinates(self, at: int, flags: list[int], short: int, same: int) -> tuple[list[float], int]:
        """Return one coordinate of every point, and where its bytes end."""
        value, values = 0, list[float]()
        for flag in flags:
            if flag & short:
                value += self._data[at] if flag & same else -self._data[at]
                at += 1
            elif not flag & same:
                value += struct.unpack_from(">h", self._data, at)[0]
                at += 2
            values.append(value)
        return values, at

    def _composite(self, at: int) -> list[list[Point]]:
        """Return the contours of a glyph that is put together of others."""
        contours: list[list[Point]] = []
        flags = _MORE
        while flags & _MORE:
            flags, part = struct.unpack_from(">HH", self._data, at)
            kind = ">hh" if flags & _WORDS else ">bb"
            right, up = struct.unpack_from(kind, self._data, at + 4) if flags & _OFFSETS else (0, 0)
            at += 4 + struct.calcsize(kind)
            a, b, c, d, size = self._matrix(at, flags)
            at += size
            contours += [
                [(a * x + c * y + right, b * x + d * y + up, on) for x, y, on in points]
                for points in self._contours(part)
            ]
        return contours

    def _matrix(self, at: int, flags: int) -> tuple[float, float, float, float, int]:
        """Return how a part is scaled and turned, and how many bytes say so."""
        count = 1 if flags & _SCALE else 2 if flags & _TWO_SCALES else 4 if flags & _MATRIX else 0
        values = [value / 16384.0 for value in struct.unpack_from(f">{count}h", self._data, at)]
        whole = {0: (1.0, 0.0, 0.0, 1.0), 4: tuple(values)}
        a, b, c, d = whole[count] if count in whole else (values[0], 0.0, 0.0, values[-1])
        return a, b, c, d, 2 * count


def _contour(points: list[Point]) -> str:
    """Return a closed contour: between two points that it bends towards it goes through their middle."""
    around: list[Point] = []
    for before, here in zip([points[-1], *points], points, strict=False):
        if not before[2] and not here[2]:
            around.append(((before[0] + here[0]) / 2.0, (before[1] + here[1]) / 2.0, True))
        around.append(here)
    first = next(index for index, point in enumerate(around) if point[2])
    around = around[first:] + around[: first + 1]
    path = [f"M{around[0][0]:g} {around[0][1]:g}"]
    for before, (x, y, on) in pairwise(around):
        if not on:
            path.append(f"Q{x:g} {y:g}")
        elif before[2]:
            path.append(f"L{x:g} {y:g}")
        else:
            path.append(f" {x:g} {y:g}")
    return "".join(path) + "Z"
