"""A folder or a manifest becomes a study: every frame in its series, everything left out with its reason."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fullwell.errors import UsageError
from fullwell.frames.cameras import combined
from fullwell.frames.checks import exclusion_findings, keep_uniform, merged, study_findings
from fullwell.frames.crop import cropped
from fullwell.frames.descriptor import is_descriptor, read_descriptor
from fullwell.frames.discovery import discover
from fullwell.frames.facts import fact_findings
from fullwell.frames.grouping import group_series
from fullwell.frames.levels import black_level, white_level
from fullwell.frames.manifest import MANIFEST_NAME, read_manifest
from fullwell.frames.reading import Reading, read_all
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera, Exclusion, Study
from fullwell.frames.source import Source
from fullwell.raw.cfa import BAYER, MONO
from fullwell.raw.headerless_format import HeaderlessFormat


def load_study(path: Path, selection: Selection) -> Study:
    """Index a study; no pixel is read.

    Parameters
    ----------
    path
        A folder with one subfolder per kind of capture, a folder that holds ``study.toml``, a manifest, or an EMVA 1288
        descriptor.
    selection
        Which part of it to use, and facts that outrank the files' own.

    Returns
    -------
    Study
        The same for any order in which the file system lists its files.

    Raises
    ------
    UsageError
        Where nothing can be measured: the sentence says what to do.

    """
    source = source_of(path, headerless=selection.headerless is not None)
    return index_source(source, path=path, selection=selection)


def index_folder(folder: Path, selection: Selection) -> Study:
    """Index a study folder by the names of its folders, whether or not it holds a manifest.

    Raises
    ------
    UsageError
        As `load_study`.

    """
    if not folder.is_dir():
        raise UsageError(
            f"{folder} is no folder. Give the folder that holds the capture folders (dark, flat, bias ...)."
        )
    source = discover(folder, headerless=selection.headerless is not None)
    return index_source(source, path=folder, selection=selection)


def index_source(source: Source, *, path: Path, selection: Selection) -> Study:
    """Read the headers of a source's files; ``path`` is what sentences call it."""
    camera = combined(selection.camera or Camera(), source.camera)
    candidates = [one for one in source.candidates if not selection.kinds or one.kind in selection.kinds]
    if not candidates:
        kinds = ", ".join(sorted({one.kind.value for one in source.candidates}))
        raise UsageError(f"--only leaves no frames of {path}: the study holds {kinds}.")
    readings, unreadable = read_all(
        candidates, camera=camera, cfa=selection.cfa, headerless=_headerless(source, selection)
    )
    if not readings:
        raise UsageError(_none_usable(path, unreadable))
    chosen = _chosen(readings, selection=selection, path=path)
    if source.descriptor:
        chosen = tuple(_monochrome(one) for one in chosen)
    known, unknown = _known_cfa(chosen, path=path)
    kept, differing = keep_uniform(known)
    excluded = tuple(sorted((*unreadable, *unknown, *differing), key=lambda one: (one.name, one.code)))
    study = _assembled(source, kept=kept, excluded=excluded, camera=camera, selection=selection)
    return study if selection.crop is None else cropped(study, selection.crop)


def _headerless(source: Source, selection: Selection) -> tuple[HeaderlessFormat, str] | None:
    """Return how files without a header are stored by the user or the manifest, and which of them says so."""
    if selection.headerless is not None:
        return selection.headerless, "--headerless"
    return None if source.headerless is None else (source.headerless, "the manifest")


def source_of(path: Path, *, headerless: bool = False) -> Source:
    """Find the files of a folder or a manifest; ``headerless`` as in `discover`.

    Raises
    ------
    UsageError
        Where the path is neither, or nothing in it could be a frame.

    """
    if not path.exists():
        raise UsageError(f"{path} does not exist. Give a study folder or a study.toml.")
    if path.is_dir():
        return (
            read_manifest(path / MANIFEST_NAME)
            if (path / MANIFEST_NAME).is_file()
            else discover(path, headerless=headerless)
        )
    if path.suffix.lower() == ".toml":
        return read_manifest(path)
    if is_descriptor(path):
        return read_descriptor(path)
    raise UsageError(
        f"{path} is a single file, not a study. Give the folder that holds the capture folders (dark, flat, bias ...), "
        "a study.toml or an EMVA 1288 descriptor (a text in UTF-8); `fullwell inspect` tells what a single raw file is."
    )


def _chosen(readings: Sequence[Reading], *, selection: Selection, path: Path) -> tuple[Reading, ...]:
    chosen = tuple(
        one for one in readings if selection.wants(iso=one.frame.header.iso, exposure_s=one.frame.header.exposure_s)
    )
    if not chosen:
        isos = sorted({iso for one in readings if (iso := one.frame.header.iso) is not None})
        exposures = sorted({exposure for one in readings if (exposure := one.frame.header.exposure_s) is not None})
        raise UsageError(
            f"--iso and --exposure leave no frames of {path}. It holds ISO {_few(isos)} and exposures "
            f"{_few(exposures)} s."
        )
    return chosen


def _monochrome(reading: Reading) -> Reading:
    """Return a frame of a descriptor, which is monochrome where nothing says its colour-filter array."""
    header = reading.frame.header
    return reading if header.cfa else replace(reading, frame=replace(reading.frame, header=replace(header, cfa=MONO)))


def _few(values: Sequence[float]) -> str:
    if not values:
        return "unknown"
    shown = " ".join(f"{value:.6g}" for value in values[:12])
    return shown if len(values) <= 12 else f"{shown} ..."


def _known_cfa(readings: Sequence[Reading], *, path: Path) -> tuple[tuple[Reading, ...], tuple[Exclusion, ...]]:
    """Part the frames whose CFA is known from the others; where no frame's is, ask for it."""
    known = tuple(one for one in readings if one.frame.header.cfa is not None)
    allowed = ", ".join((*BAYER, MONO))
    if not known:
        raise UsageError(
            f"The frames of {path} do not say their colour-filter array (the first: {readings[0].frame.name}). Give it "
            f"with --cfa, or as cfa in the [camera] table of study.toml: {allowed}."
        )
    reason = f"nothing says its colour-filter array, though other frames have one; give --cfa ({allowed})"
    unknown = tuple(
        Exclusion(name=one.frame.name, code="cfa-unknown", reason=reason)
        for one in readings
        if one.frame.header.cfa is None
    )
    return known, unknown


def _none_usable(path: Path, excluded: Sequence[Exclusion]) -> str:
    first = excluded[0]
    reason = first.reason.rstrip(".")
    return f"None of the {len(excluded)} raw files in {path} can be measured. The first, {first.name}: {reason}."


def _assembled(
    source: Source,
    *,
    kept: Sequence[Reading],
    excluded: tuple[Exclusion, ...],
    camera: Camera,
    selection: Selection,
) -> Study:
    series = group_series(kept, light=source.light, area_um2=camera.area_um2)
    depths = Counter(one.bit_depth for one in kept)
    bit_depth = min(depths, key=lambda depth: (-depths[depth], depth))
    header = kept[0].frame.header
    cfa = header.cfa or MONO
    black = black_level(kept, selection=selection, camera=camera, cfa=cfa)
    white = white_level(kept, selection=selection, camera=camera, cfa=cfa, bit_depth=bit_depth)
    if black is not None and white is not None and max(black.values) >= min(white.values):
        raise UsageError(
            f"The black level {max(black.values):g} DN ({black.source}) is not below the white level "
            f"{min(white.values):g} DN ({white.source}). Give --black and --white, or correct study.toml."
        )
    findings = (
        *source.findings,
        *exclusion_findings(excluded),
        *study_findings(series, kept),
        *fact_findings(kept, given=selection.camera, camera=camera, white=white),
        *(finding for one in kept for finding in one.findings),
    )
    return Study(
        root=source.root,
        camera=camera if camera.name else replace(camera, name=_camera_name(kept)),
        series=series,
        width=header.width,
        height=header.height,
        cfa=cfa,
        bit_depth=bit_depth,
        black_level=black,
        white_level=white,
        excluded=excluded,
        findings=merged(findings),
        light=source.light,
        campaign=source.campaign,
        descriptor=source.descriptor,
    )


def _camera_name(readings: Sequence[Reading]) -> str | None:
    """Return the camera that most files name; None where they name none."""
    names = Counter(name for one in readings if (name := one.frame.header.camera))
    return min(names, key=lambda name: (-names[name], name)) if names else None
