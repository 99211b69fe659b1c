"""What one ISO leaves in ``maps/``: the response of every pixel, and the shading of every flat burst."""

from pathlib import Path

from fullwell.frames.series import Study
from fullwell.workflow.maps import (
    ChannelMap,
    NamedArray,
    ShadingMapFile,
    map_grid,
    save_pixel_maps,
    save_shading_map,
)
from fullwell.workflow.measure.bursts import IsoBursts
from fullwell.workflow.measure.iso import IsoMeasurement
from fullwell.workflow.measure.pattern_maps import INTERCEPT, SLOPE, IsoMaps
from fullwell.workflow.measure.shading import BurstShading, ChannelShading


def write_response_maps(study: Study, bursts: IsoBursts, maps: IsoMaps, folder: Path) -> None:
    """Write the response of every pixel at one ISO into a folder, which is made if need be."""
    if SLOPE not in maps.mosaics:
        return
    folder.mkdir(parents=True, exist_ok=True)
    iso = bursts.iso
    arrays = {
        "slope": NamedArray(
            values=maps.mosaics[SLOPE], unit="DN/s", description="response of each pixel against exposure, mosaic"
        ),
        "intercept": NamedArray(
            values=maps.mosaics[INTERCEPT], unit="DN", description="level of each pixel at no exposure, mosaic"
        ),
    }
    exposures = {one.channel: [burst.exposure_s for burst in one.flats] for one in maps.channels}
    about = {"iso": iso, "cfa": study.cfa, "exposures_s": exposures, "source": "METHOD 5.2"}
    save_pixel_maps(folder / f"response_iso{'unknown' if iso is None else f'{iso:g}'}.npz", arrays, about=about)


def write_shading_maps(study: Study, measured: IsoMeasurement, folder: Path) -> None:
    """Write the shading of every flat burst of an ISO into a folder, which is made if need be."""
    for one in measured.shadings:
        if len(one.channels) < len(measured.bursts.channels):
            continue
        folder.mkdir(parents=True, exist_ok=True)
        save_shading_map(folder, shading_file(study, one))


def shading_file(study: Study, shading: BurstShading) -> ShadingMapFile:
    """Return the shading of a burst as it is kept on disk."""
    return ShadingMapFile(
        cfa=study.cfa,
        width=study.width,
        height=study.height,
        orientation=shading.burst.series.frames[0].header.orientation,
        iso=shading.iso,
        exposure_s=shading.burst.exposure_s,
        camera=study.camera.name,
        channels=tuple(_channel(one) for one in shading.channels),
    )


def _channel(one: ChannelShading) -> ChannelMap:
    model, data = one.fits.best, one.data
    rows, columns = map_grid(data.plane_shape)
    return ChannelMap(
        channel=one.channel,
        model=model.name,
        parameters=model.to_arrays(),
        data=data,
        grid_row=rows,
        grid_column=columns,
        normalized=model.surface(rows[:, None], columns[None, :]) / model.maximum_dn,
        centre=model.centre,
        maximum_dn=model.maximum_dn,
        black_level_dn=one.black_dn,
    )
