"""What results.json says under ``study``: what was read, its content hashes, and what was left out (RESULTS 2)."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict

from fullwell.frames.campaign import Campaign
from fullwell.frames.series import Camera, Exclusion, Frame, Light, Series, Study
from fullwell.raw.image import Levels


def describe(
    study: Study,
    *,
    settings: Mapping[str, object],
    hashes: Mapping[str, str],
    excluded: Iterable[Exclusion],
    **more: object,
) -> Mapping[str, object]:
    """Return the description of a study.

    Parameters
    ----------
    study
        What was indexed.
    settings
        What changes numbers.
    hashes
        xxh3-128 of every file that was read, by frame name.
    excluded
        Frames left out after indexing.
    **more
        Entries of their own.

    """
    gone = {one.name for one in excluded}
    every = sorted((*study.excluded, *excluded), key=lambda one: one.name)
    return {
        "camera": _known(study.camera),
        "bodies": _bodies(study),
        "light": _known(study.light),
        "emva": _known(study.campaign),
        "width": study.width,
        "height": study.height,
        "cfa": study.cfa,
        "bit_depth": study.bit_depth,
        "black_level": _levels(study.black_level),
        "white_level": _levels(study.white_level),
        "settings": settings,
        **more,
        "series": [_series(series, gone) for series in study.series],
        "files": [_file(series, frame, hashes) for series in study.series for frame in series.frames],
        "excluded": [{"path": one.name, "code": one.code, "reason": one.reason} for one in every],
    }


def _known(facts: Camera | Light | Campaign) -> Mapping[str, object]:
    return {name: value for name, value in asdict(facts).items() if value is not None}


def _bodies(study: Study) -> list[Mapping[str, object]]:
    """Return every body that the files name, with its firmware and how many frames name it."""
    headers = (frame.header for series in study.series for frame in series.frames)
    counts = Counter((one.make, one.model, one.serial, one.firmware) for one in headers)
    return [
        {"make": make, "model": model, "serial": serial, "firmware": firmware, "frames": frames}
        for (make, model, serial, firmware), frames in sorted(counts.items(), key=lambda item: tuple(map(str, item[0])))
        if make or model or serial or firmware
    ]


def _levels(levels: Levels | None) -> Mapping[str, object] | None:
    return None if levels is None else {"values": list(levels.values), "source": levels.source, "tag": levels.tag}


def _series(series: Series, gone: set[str]) -> Mapping[str, object]:
    return {
        "kind": series.kind.value,
        "iso": series.iso,
        "exposure_s": series.exposure_s,
        "temperature_c": series.temperature_c,
        "photons": series.photons,
        "stack": series.stack,
        "frames": sum(frame.name not in gone for frame in series.frames),
    }


def _file(series: Series, frame: Frame, hashes: Mapping[str, str]) -> Mapping[str, object]:
    return {
        "path": frame.name,
        "size": frame.size,
        "xxh3_128": hashes.get(frame.name),
        "kind": series.kind.value,
        "iso": series.iso,
        "exposure_s": series.exposure_s,
        "black_level": _levels(frame.header.black_level),
        "white_level": _levels(frame.header.white_level),
    }
