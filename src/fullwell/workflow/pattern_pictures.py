"""The small arrays of shading and pixel responses that a report shows as pictures."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.legacy.shading_map import Poly22, evaluate
from fullwell.frames.series import SeriesKey, Study
from fullwell.report.pictures import ResponsePicture, ShadingDifferencePicture, ShadingPicture
from fullwell.workflow.measure.pattern_maps import SLOPE, IsoMaps
from fullwell.workflow.measure.regions import Region, central_crop, central_tiles
from fullwell.workflow.measure.shading import BurstShading, ChannelShading, longest_whole
from fullwell.workflow.measure.shading_differences import BurstDifference

MOST_POINTS: Final = 64
MOST_RESPONSE: Final = 128
Surfaces = Mapping[tuple[SeriesKey, str], Poly22]
"""The published study's surface by the key of the series and channel."""


def shading_pictures(shadings: Sequence[BurstShading], surfaces: Surfaces) -> tuple[ShadingPicture, ...]:
    """Return the pictures of the longest exposed burst of one ISO among those of most channels, one per channel."""
    pictures: list[ShadingPicture] = []
    for shading in longest_whole(shadings):
        rows, columns = (
            min(sizes) for sizes in zip(*(one.data.signal_dn.shape for one in shading.channels), strict=True)
        )
        pictures += [
            _shading_picture(shading, one, (rows, columns), surfaces.get((shading.burst.series.key, one.channel)))
            for one in shading.channels
        ]
    return tuple(pictures)


def _shading_picture(
    shading: BurstShading, one: ChannelShading, shape: tuple[int, int], surface: Poly22 | None
) -> ShadingPicture:
    """Return the picture of one channel on the rows and columns of bins that all channels have."""
    data, model = one.data, one.fits.best
    step = -(-max(shape) // MOST_POINTS)
    rows, columns = data.rows[: shape[0] : step], data.columns[: shape[1] : step]
    measured = data.signal_dn[: shape[0] : step, : shape[1] : step]
    fitted = model.surface(rows[:, None], columns[None, :])
    cosine = one.fits.models.get("cos4-fixed")
    return ShadingPicture(
        iso=shading.iso,
        exposure_s=shading.burst.exposure_s,
        channel=one.channel,
        model=model.name,
        rows=rows,
        columns=columns,
        measured=measured,
        fitted=fitted,
        normalized=fitted / model.maximum_dn,
        residual=measured / fitted - 1.0,
        cos4=None if cosine is None else cosine.surface(rows[:, None], columns[None, :]) / cosine.maximum_dn,
        legacy=(
            None if surface is None else evaluate(surface.coefficients, rows + 1.0, columns + 1.0) / surface.maximum
        ),
    )


def difference_pictures(differences: Iterable[BurstDifference]) -> tuple[ShadingDifferencePicture, ...]:
    """Return how every burst differs from the base, channels averaged."""
    pictures: list[ShadingDifferencePicture] = []
    for one in differences:
        own = [difference for _, difference in one.channels]
        shape = tuple(min(sizes) for sizes in zip(*(each.difference.shape for each in own), strict=True))
        cut = (slice(shape[0]), slice(shape[1]))
        difference = np.mean([each.difference[cut] for each in own], axis=0)
        error = np.sqrt(np.sum([each.std_error[cut] ** 2 for each in own], axis=0)) / len(own)
        smallest = min(each.p_value for each in own)
        pictures.append(
            ShadingDifferencePicture(
                iso=one.other.iso,
                exposure_s=one.other.burst.exposure_s,
                base_iso=one.base.iso,
                base_exposure_s=one.base.burst.exposure_s,
                difference=difference,
                over_error=difference / error,
                p_value=min(1.0, len(own) * smallest),
            )
        )
    return tuple(pictures)


def response_pictures(study: Study, iso: float | None, maps: IsoMaps) -> tuple[ResponsePicture, ...]:
    """Return the slopes of the central megapixel and of one tile in it."""
    if SLOPE not in maps.mosaics:
        return ()
    crop = central_crop(width=study.width, height=study.height)
    tile = central_tiles(width=study.width, height=study.height)[5]
    plane = next((one for one in maps.channels if one.channel in {"G1", "mono"} and SLOPE in one.maps), None)
    if plane is None or tile.width < 8:
        return ()
    cell = 1 if plane.channel == "mono" else 2

    def picture(region: Region, kind: Literal["crop", "tile"], said: str) -> ResponsePicture:
        return ResponsePicture(
            iso=iso,
            channel=plane.channel,
            title=f"slope of every pixel of {plane.channel} at {region.x}, {region.y}, {said}",
            image=_binned(plane.maps[SLOPE][region.plane(cell)]),
            unit="DN/s",
            kind=kind,
        )

    return picture(crop, "crop", "central crop"), picture(tile, "tile", "one tile of it")


def _binned(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return means over blocks so small that at most 128 x 128 are left."""
    step = max(1, -(-max(values.shape) // MOST_RESPONSE))
    rows, columns = (size // step for size in values.shape)
    blocks = values[: rows * step, : columns * step].reshape(rows, step, columns, step)
    return blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
