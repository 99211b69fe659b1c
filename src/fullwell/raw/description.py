"""What LibRaw and a file's own tags say of a maker's raw file, as it comes out of the process of the decoders."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from fullwell.raw.exif import ExifTags, Values
from fullwell.raw.image import Area


@dataclass(frozen=True, slots=True, kw_only=True)
class Margin:
    """A margin beside the visible area, with the median of its codes and of the visible ones [DN]."""

    area: Area
    median: float
    visible: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Decoded:
    """What LibRaw says of a file that it reads.

    Parameters
    ----------
    raw_width, raw_height
        Size of the stored mosaic [pixel].
    visible
        The visible area, as LibRaw has it: it may lie outside the stored mosaic.
    flip
        Orientation by LibRaw's numbers.
    flat
        Whether there is one number for every pixel.
    last_row_is_flat
        Whether the last row holds a single code, as where a decoder ran out of data.
    pattern
        Number of each site's colour from the visible top-left pixel, row-major; one number for mono, empty where
        LibRaw cannot say.
    colours
        Letters of the colours, by number.
    black, linear
        Black levels and limits of linearity by number of colour; ``linear`` is empty where the file has none [DN].
    white
        [DN].
    iso, exposure_s
        0 where unknown.
    longest_step
        Longest step between codes that the file's tone curve leads to [DN].
    balance
        Multipliers that make white grey, by number of colour; 0 where unknown.
    matrix
        From XYZ to the camera's R, G and B in daylight, nine numbers; all 0 where LibRaw does not know the camera.
    margins
        Margins of at least 4 rows or columns.

    """

    raw_width: int
    raw_height: int
    visible: Area
    flip: int
    flat: bool
    last_row_is_flat: bool
    pattern: tuple[int, ...]
    colours: str
    black: tuple[float, ...]
    linear: tuple[float, ...]
    white: int
    iso: float
    exposure_s: float
    longest_step: int
    balance: tuple[float, ...]
    matrix: tuple[float, ...]
    margins: tuple[Margin, ...]

    @property
    def visible_lies_inside(self) -> bool:
        """Return whether the visible area lies within the stored mosaic."""
        top, left, bottom, right = self.visible
        return 0 <= top < bottom <= self.raw_height and 0 <= left < right <= self.raw_width


@dataclass(frozen=True, slots=True, kw_only=True)
class Container:
    """What a file's own structure says.

    Parameters
    ----------
    tags
        Every short tag, as directory, number and values.
    make, model
        Of a CRW file, which has no EXIF tags.
    wavelet_levels
        Of a CR3 file; more than 0 means lossy.
    fuji_lossy, fuji_rotated
        Whether a RAF file says that it is coded with loss, or that its pixels stand diagonally.
    end
        Where a RAF or CR3 file must end at the earliest, by what it says; 0 for others [byte].

    """

    tags: tuple[tuple[str, int, Values], ...]
    make: str | None
    model: str | None
    wavelet_levels: int
    fuji_lossy: bool
    fuji_rotated: bool
    end: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """What is known of a maker's raw file.

    Parameters
    ----------
    decoded
        None where LibRaw does not read it.
    refusal
        Code and reason of LibRaw's; None where it reads the file.
    container
        What the file's structure says, whether or not LibRaw reads it.

    """

    decoded: Decoded | None
    refusal: tuple[str, str] | None
    container: Container

    @property
    def tags(self) -> ExifTags:
        """Return the file's tags."""
        return ExifTags(entries=self.container.tags)

    def as_plain(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self)

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Description":
        """Return what `as_plain` was made of."""
        container = plain["container"]
        tags = tuple(
            (directory, number, values if isinstance(values, str) else tuple(values))
            for directory, number, values in container["tags"]
        )
        refusal = plain["refusal"]
        return cls(
            decoded=None if plain["decoded"] is None else _decoded(plain["decoded"]),
            refusal=None if refusal is None else (refusal[0], refusal[1]),
            container=Container(**(container | {"tags": tags})),
        )


def _decoded(plain: Mapping[str, Any]) -> Decoded:
    known: dict[str, Any] = dict(plain)
    for name in ("pattern", "black", "linear", "balance", "matrix"):
        known[name] = tuple(known[name])
    known["visible"] = Area(*known["visible"])
    known["margins"] = tuple(Margin(**(one | {"area": Area(*one["area"])})) for one in known["margins"])
    return Decoded(**known)
