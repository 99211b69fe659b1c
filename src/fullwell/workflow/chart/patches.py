"""Where the patches of each scene are: as given, as located, or as a file beside the shots says."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from fullwell.errors import RawFileError, UsageError
from fullwell.findings import Finding, Severity
from fullwell.frames.chart.definition import ChartDefinition, chart_named, chart_names
from fullwell.frames.chart.locate import CONFIDENCE, Located, Point, locate
from fullwell.frames.chart.patches import Patch, check_patches, read_patches, within
from fullwell.frames.series import Frame, Series, Study
from fullwell.raw.cfa import cell
from fullwell.workflow.chart.reading import Placed, mosaic_of

BESIDE: Final = "patches.csv"
"""Name, in any case, of a file that says where the patches of the shots in its folder are."""

Frames = Sequence[tuple[Series, Frame]]
Corners = tuple[Point, Point, Point, Point]
Region = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class WhereAbouts:
    """What the user says about the patches; exactly one of the first two.

    Parameters
    ----------
    patches
        One file for all scenes, or one for each.
    chart
        Name of a chart, or a TOML file that describes one.
    corners
        x, y of the chart's corners, clockwise from its own top left, where the user knows them [pixel].

    """

    patches: tuple[Path, ...] = ()
    chart: str | None = None
    corners: Corners | None = None


def place(
    study: Study, scenes: Sequence[Frames], where: WhereAbouts, *, crop: Region | None = None
) -> tuple[tuple[Placed, ...], tuple[Finding, ...]]:
    """Return every scene with its patches.

    Parameters
    ----------
    study
        What the frames have in common.
    scenes
        Frames of each still scene.
    where
        What the user says, of the whole visible mosaic.
    crop
        Region of it that the study was cut to.

    Raises
    ------
    UsageError
        Where patches do not fit the frames, or a chart is not found beyond doubt.

    """
    if len(where.patches) not in {0, 1, len(scenes)}:
        raise UsageError(
            f"--patches is given {len(where.patches)} times for {len(scenes)} scenes; give it once, or once for each."
        )
    placed: list[Placed] = []
    findings: list[Finding] = []
    for number, frames in enumerate(scenes):
        located: Located | None = None
        if where.patches:
            patches = _read(study, where.patches[number if len(where.patches) > 1 else 0], crop)
        else:
            located = _located(study, frames, chart_named(where.chart or ""), _moved(where.corners, crop))
            _require_trust(located, frames)
            patches = located.patches
        findings += _checked(study, patches)
        placed.append(Placed(name=frames[0][1].name, frames=tuple(frames), patches=patches, located=located))
    return tuple(placed), tuple(dict.fromkeys(findings))


def place_unasked(
    study: Study, scenes: Sequence[Frames], *, crop: Region | None = None
) -> tuple[tuple[Placed, ...], tuple[Finding, ...]]:
    """Return the scenes of a study whose patches a file beside them gives, or that show a chart we know.

    Bad patches and scenes without a chart become findings.
    """
    placed: list[Placed] = []
    findings: list[Finding] = []
    for frames in scenes:
        name, names = frames[0][1].name, tuple(sorted(frame.name for _, frame in frames))
        beside = _beside(frames)
        try:
            if beside is not None:
                located, patches = None, _read(study, beside, crop)
                findings += _checked(study, patches)
            else:
                located = _best(study, frames)
                patches = located.patches
        except UsageError as error:
            message = f"the chart of {name} is not measured: {str(error).rstrip('.')}"
            findings.append(Finding(code="patches-unusable", severity=Severity.ERROR, message=message, files=names))
            continue
        if located is not None and located.confidence < CONFIDENCE:
            message = (
                f"no chart was found in {name} ({located.reason.rstrip('.') or 'nothing like one'}); put a patches.csv "
                "beside it, or measure it with `fullwell chart --chart NAME --corners ...`"
            )
            findings.append(Finding(code="chart-not-found", severity=Severity.WARNING, message=message, files=names))
            continue
        placed.append(Placed(name=name, frames=tuple(frames), patches=patches, located=located))
    return tuple(placed), tuple(dict.fromkeys(findings))


def located_finding(placed: Sequence[Placed]) -> tuple[Finding, ...]:
    """Say how sure the location of every chart is."""
    return tuple(
        Finding(
            code="chart-located",
            severity=Severity.INFO,
            message=(
                f"the chart of {one.name} was found with a confidence of {one.located.confidence:.2f}; look at the "
                "picture with the patches before you trust the figures"
            ),
            files=(one.name,),
        )
        for one in placed
        if one.located is not None
    )


def _read(study: Study, path: Path, crop: Region | None) -> tuple[Patch, ...]:
    patches = read_patches(path)
    return patches if crop is None else within(patches, crop, cell=cell(study.cfa))


def _moved(corners: Corners | None, crop: Region | None) -> Corners | None:
    if corners is None or crop is None:
        return corners
    first, second, third, fourth = ((x - crop[0], y - crop[1]) for x, y in corners)
    return first, second, third, fourth


def _located(study: Study, frames: Frames, definition: ChartDefinition, corners: Corners | None) -> Located:
    """Locate a chart in the longest exposure that shows it beyond doubt, else as well as any does."""
    best: Located | None = None
    for frame in _first_of_each(frames):
        try:
            mosaic = mosaic_of(frame)
        except (RawFileError, OSError):
            continue
        found = locate(
            mosaic,
            cfa=study.cfa,
            black=_mean(study.black_level.values) if study.black_level else 0.0,
            white=_mean(study.white_level.values) if study.white_level else float(2**study.bit_depth - 1),
            definition=definition,
            corners=corners,
        )
        if best is None or found.confidence > best.confidence:
            best = found
        if best.confidence >= CONFIDENCE:
            break
    if best is None:
        return Located(patches=(), confidence=0.0, corners=(), orientation=0, reason="no frame can be read")
    return best


def _best(study: Study, frames: Frames) -> Located:
    found = [_located(study, frames, chart_named(name), None) for name in chart_names()]
    return max(found, key=lambda one: one.confidence)


def _require_trust(located: Located, frames: Frames) -> None:
    if located.confidence >= CONFIDENCE:
        return
    why = located.reason.rstrip(".") or "Nothing in the picture fits it; give the patches with --patches"
    raise UsageError(f"{frames[0][1].name}: {why[:1].lower()}{why[1:]}.")


def _first_of_each(frames: Frames) -> list[Frame]:
    """Return the first frame of each exposure, the longest first."""
    firsts = {series.key: frame for series, frame in reversed(list(frames))}
    return [firsts[key] for key in sorted(firsts, reverse=True)]


def _checked(study: Study, patches: Sequence[Patch]) -> tuple[Finding, ...]:
    return check_patches(patches, width=study.width, height=study.height, cell=cell(study.cfa))


def _beside(frames: Frames) -> Path | None:
    folder = frames[0][1].header.path.parent
    return next((path for path in sorted(folder.iterdir()) if path.name.lower() == BESIDE), None)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
