"""Raw files to look at: a preview, and the four CFA orders side by side."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.errors import UsageError
from fullwell.files import fullness_named
from fullwell.raw.cfa import BAYER, MONO, cell, channels
from fullwell.raw.image import Levels, RawHeader
from fullwell.raw.open import decode, read_bytes
from fullwell.raw.tiff_file import write_whole
from fullwell.render.demosaic import demosaic
from fullwell.render.picture import reduced, upright
from fullwell.render.tone import grey_world, relative, srgb_curve, white_balanced
from fullwell.report.numbers import show_exposure
from fullwell.report.plots_preview import OrderView, Plane, Preview, orders_png, preview_png

FloatImage = NDArray[np.float32]
Draw = Callable[[RawHeader, NDArray[np.uint16]], bytes]
"""Draws the sheet of one file from its header and mosaic, as a PNG."""

_LONGEST: Final = 1100
_PLANE_LONGEST: Final = 420
_DETAIL: Final = 48
_BRIGHT: Final = 99.7
"""Percentile of light that is shown white."""


def preview_of(header: RawHeader, mosaic: NDArray[np.uint16]) -> bytes:
    """Return a PNG of a raw file: picture, colour planes in false colours, codes with black and white level.

    Parameters
    ----------
    header
        What the file says about itself.
    mosaic
        Its visible mosaic, shape (height, width) [DN].

    """
    cfa = _usable_cfa(header)
    light = _light(header, mosaic, cfa)
    bright = _brightest(light)
    rgb = reduced(demosaic(light, cfa=cfa), longest=_LONGEST)
    neutral = _neutral(header, light, cfa)
    shown = srgb_curve(white_balanced(rgb, neutral=neutral) * np.float32(1.0 / bright))
    made = "demosaicked, white balanced, " if cfa != MONO else ""
    return preview_png(
        Preview(
            title=header.path.name,
            subtitle=_subtitle(header),
            picture=upright(shown, header.orientation),
            caption=f"{made}{_stretch(bright)}, sRGB curve",
            planes=_planes(header, mosaic, light, cfa),
        )
    )


def orders_of(header: RawHeader, mosaic: NDArray[np.uint16]) -> bytes:
    """Return a PNG of a mosaic rendered in the four Bayer orders, to choose the right one by eye."""
    views: list[OrderView] = []
    top, left = _colourful(_light(header, mosaic, BAYER[0]))
    detail = (slice(top, top + _DETAIL), slice(left, left + _DETAIL))
    for order in BAYER:
        light = _light(header, mosaic, order)
        rgb = white_balanced(demosaic(light, cfa=order), neutral=grey_world(light, cfa=order))
        told = "  (the file says so)" if order == header.cfa else ""
        small = reduced(rgb, longest=_LONGEST // 2)
        views.append(OrderView(order=f"{order}{told}", picture=_shown(small), detail=_shown(rgb[detail])))
    return orders_png(
        header.path.name,
        "Choose by eye. Greens in the wrong place: grey colours, and a maze of pixels in the detail. Red and blue "
        "changed over: skin and bricks are blue. Each is white balanced by its own mean.",
        views,
    )


def _shown(rgb: FloatImage) -> FloatImage:
    return srgb_curve(rgb * np.float32(1.0 / _brightest(rgb)))


def write_sheets(headers: Sequence[RawHeader], path: Path, *, draw: Draw) -> tuple[Path, ...]:
    """Draw one sheet per file and return what was written.

    Parameters
    ----------
    headers
        Of files whose pixels can be read.
    path
        The PNG of a single file; several get their own names beside it (`sheet_name`).
    draw
        `preview_of` or `orders_of`.

    Raises
    ------
    UsageError
        Where the path is no PNG, or one of the files.

    """
    if path.suffix.lower() != ".png":
        raise UsageError(f"{path} is written as a PNG; give a name that ends in .png.")
    stems = [header.path.stem for header in headers]
    targets = [
        path if len(headers) == 1 else path.with_name(sheet_name(path, header.path, stems=stems)) for header in headers
    ]
    if any(target.exists() and target.samefile(header.path) for target in targets for header in headers):
        raise UsageError(f"{path} would replace a raw file; give another name.")
    for header, target in zip(headers, targets, strict=True):
        with fullness_named(target):
            write_whole(target, [draw(header, decode(header, read_bytes(header)))])
    return tuple(targets)


def sheet_name(path: Path, source: Path, *, stems: Sequence[str]) -> str:
    """Return the name of one file's sheet among several: the file's own behind the one that was given.

    Examples
    --------
    >>> sheet_name(Path("look.png"), Path("a/IMG_1.dng"), stems=["IMG_1", "IMG_2"])
    'look-IMG_1.png'
    >>> sheet_name(Path("look.png"), Path("a/IMG_1.dng"), stems=["IMG_1", "IMG_1"])
    'look-IMG_1.dng.png'

    """
    name = source.stem if stems.count(source.stem) < 2 else source.name
    return f"{path.stem}-{name}{path.suffix}"


def _usable_cfa(header: RawHeader) -> str:
    return header.cfa if header.cfa in BAYER and min(header.width, header.height) > 1 else MONO


def _light(header: RawHeader, mosaic: NDArray[np.uint16], cfa: str) -> FloatImage:
    """Return codes from black 0 to white 1; levels that nobody declares are 0 and the highest code of the bits."""
    sites = cell(cfa) ** 2
    black = _per_site(header.black_level, sites, 0.0)
    white = _per_site(header.white_level, sites, 2.0**header.bit_depth - 1.0)
    above = tuple(max(high, low + 1.0) for low, high in zip(black, white, strict=True))
    return relative(mosaic, cfa=cfa, black_level=black, white_level=above)


def _per_site(levels: Levels | None, sites: int, default: float) -> tuple[float, ...]:
    if levels is None:
        return (default,) * sites
    return levels.values if len(levels.values) == sites else (float(np.mean(levels.values)),) * sites


def _brightest(light: FloatImage) -> float:
    """Return the light that is shown white; an even frame is shown in a middle grey."""
    bright = max(float(np.percentile(light, _BRIGHT)), 2.0 * float(np.median(light)))
    return bright if bright > 0.0 else 1.0


def _neutral(header: RawHeader, light: FloatImage, cfa: str) -> tuple[float, ...]:
    known = header.as_shot_neutral
    return known if cfa != MONO and len(set(known)) > 1 else grey_world(light, cfa=cfa)


def _planes(header: RawHeader, mosaic: NDArray[np.uint16], light: FloatImage, cfa: str) -> tuple[Plane, ...]:
    period = cell(cfa)
    sites = period * period
    planes: list[Plane] = []
    for site, channel in enumerate(channels(cfa)):
        window = (slice(site // period, None, period), slice(site % period, None, period))
        blacks, whites = (_per_site(one, sites, math.nan)[site] for one in (header.black_level, header.white_level))
        plane = light[window]
        seen = _centre(plane) if cfa == MONO else reduced(plane[..., None], longest=_PLANE_LONGEST)[..., 0]
        planes.append(
            Plane(
                channel=channel,
                image=upright(srgb_curve(seen / np.float32(_brightest(plane))), header.orientation),
                counts=np.bincount(mosaic[window].ravel()),
                black_level=None if math.isnan(blacks) else blacks,
                white_level=None if math.isnan(whites) else whites,
            )
        )
    return tuple(planes)


def _centre(light: FloatImage) -> FloatImage:
    top, left = (max(0, (side - 2 * _DETAIL) // 2) for side in light.shape)
    return light[top : top + 2 * _DETAIL, left : left + 2 * _DETAIL]


def _colourful(light: FloatImage) -> tuple[int, int]:
    """Return the corner of the well-lit square whose sites differ most from their usual proportions."""
    height, width = (side // _DETAIL * _DETAIL for side in light.shape)
    if min(height, width) < _DETAIL:
        return 0, 0
    sites = [light[row:height:2, column:width:2] for row in (0, 1) for column in (0, 1)]
    half = _DETAIL // 2
    means = [one.reshape(height // _DETAIL, half, width // _DETAIL, half).mean(axis=(1, 3)) for one in sites]
    usual = np.stack([one / max(float(np.median(one)), 1e-9) for one in means])
    level = np.mean(means, axis=0)
    lit = (level >= np.quantile(level, 0.2)) & (level <= np.quantile(level, 0.95))
    colour = np.where(lit, np.ptp(usual, axis=0) / np.maximum(usual.mean(axis=0), 1e-9), 0.0)
    row, column = np.unravel_index(int(colour.argmax()), colour.shape)
    return int(row) * _DETAIL, int(column) * _DETAIL


def _stretch(bright: float) -> str:
    return f"{1.0 / bright:.3g} times as bright as the white level has it"


def _subtitle(header: RawHeader) -> str:
    model = header.model or header.make or "camera unknown"
    iso = "ISO unknown" if header.iso is None else f"ISO {header.iso:g}"
    exposure = "exposure unknown" if header.exposure_s is None else show_exposure(header.exposure_s)
    cfa = header.cfa or "CFA unknown, shown without colours (see --cfa-sheet)"
    return f"{model}   ·   {header.width} x {header.height}, {cfa}, {header.bit_depth} bit   ·   {iso}, {exposure}"
