"""A file that was read becomes what is written: its mosaic with margins, or rescaled, or a picture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fullwell.frames.series import CONTAINER_BITS
from fullwell.raw.cfa import MONO, channels
from fullwell.raw.image import Area
from fullwell.raw.open import decode, read_bytes
from fullwell.render.tone import grey_world, relative
from fullwell.workflow.convert.codes import Clipped, Codes, coloured, shifted, stretched
from fullwell.workflow.convert.settings import Conversion, FileKind
from fullwell.workflow.scenes import Scene


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recoded:
    """What is written of one file.

    Parameters
    ----------
    codes
        The mosaic; of a picture, its scale.
    rgb
        The picture, shape (height, width, 3); None where the mosaic is written.
    area
        Part of the stored frame that the mosaic is, in raw coordinates.
    shifted_out
        Codes that lost bits which were set.
    clipped
        What the new scale does not hold; None where the scale is the old one.
    neutral
        White that was balanced away; empty where nothing was.

    """

    codes: Codes
    rgb: NDArray[np.uint16] | None
    area: Area
    shifted_out: int
    clipped: Clipped | None
    neutral: tuple[float, ...] = ()


def recoded(scene: Scene, conversion: Conversion, *, kind: FileKind) -> Recoded:
    """Read a file's pixels and bring them to the scale that was asked for.

    Parameters
    ----------
    scene
        The file.
    conversion
        What is asked for.
    kind
        What is written: TIFF has no place for margins.

    Raises
    ------
    UnreadableFileError, UnsuitableFileError
        Where the pixels cannot be read, or cannot be brought to that scale.

    """
    header = scene.header
    area = _kept_area(scene) if kind == "dng" and not conversion.rescales else header.active_area
    mosaic = decode(replace(header, active_area=area), read_bytes(header))
    codes = Codes(
        mosaic=mosaic,
        black_level=scene.black_level and scene.black_level.values,
        white_level=scene.white_level.values,
        bit_depth=_bit_depth(scene, mosaic),
    )
    codes, lost = shifted(codes, conversion.bit_shift)
    if not conversion.rescales:
        return Recoded(codes=codes, rgb=None, area=area, shifted_out=lost, clipped=None)
    neutral = _neutral(scene, codes) if conversion.white_balance else ()
    factors = _factors(scene.cfa, neutral)
    scaled, clipped = stretched(codes, cfa=scene.cfa, factors=factors)
    rgb = None
    if conversion.demosaic:
        rgb, clipped = coloured(codes, cfa=scene.cfa, factors=factors)
    return Recoded(codes=scaled, rgb=rgb, area=area, shifted_out=lost, clipped=clipped, neutral=neutral)


def _kept_area(scene: Scene) -> Area:
    """Return the stored frame, without its first row or column where the visible mosaic began at an odd one.

    LibRaw begins such a mosaic one row or column later, but reads the black levels as if it had not.
    """
    header = scene.header
    odd = (header.active_area.top % 2, header.active_area.left % 2) if scene.cfa != MONO else (0, 0)
    return Area(*odd, header.raw_height, header.raw_width)


def _bit_depth(scene: Scene, mosaic: NDArray[np.uint16]) -> int:
    """Return the bits that hold every code and the white level, where the file tells no more than its container's.

    A LinearizationTable may have given codes more bits than are stored.
    """
    told = scene.header.white_level is not None and scene.bit_depth == CONTAINER_BITS
    stated = int(max(scene.white_level.values)).bit_length() if told else scene.bit_depth
    return max(stated, int(mosaic.max()).bit_length(), 1)


def _neutral(scene: Scene, codes: Codes) -> tuple[float, ...]:
    """Return white in the camera's colours, as the file has it, else from the mean of the picture; empty for mono."""
    known = scene.header.as_shot_neutral
    if scene.cfa == MONO or codes.black_level is None:
        return ()
    if len(set(known)) > 1:
        return known
    light = relative(codes.mosaic, cfa=scene.cfa, black_level=codes.black_level, white_level=codes.white_level)
    return grey_world(light, cfa=scene.cfa)


def _factors(cfa: str, neutral: Sequence[float]) -> tuple[float, ...]:
    """Return what each site is multiplied by: 1 for the colour that is strongest in white."""
    if not neutral:
        return (1.0,) * len(channels(cfa))
    return tuple(max(neutral) / neutral["RGB".index(name[0])] for name in channels(cfa))
