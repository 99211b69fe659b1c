"""``fullwell convert``: raw files as DNG or TIFF, mosaic and levels kept."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from fullwell.errors import RawFileError, UsageError
from fullwell.files import fullness_named
from fullwell.findings import Finding, Severity
from fullwell.workflow.convert.kept import conversion_findings
from fullwell.workflow.convert.recoding import Recoded, recoded
from fullwell.workflow.convert.settings import Conversion, FileKind
from fullwell.workflow.convert.targets import frame_target, planned, require_free
from fullwell.workflow.convert.writing import write_converted, written_black
from fullwell.workflow.executor import Progress, in_threads
from fullwell.workflow.options import Options
from fullwell.workflow.scenes import Scene, read_scenes

SCHEMA: Final = "fullwell-convert/1"
_MOST_AT_ONCE: Final = 4
"""Files in memory at the same time: a large one takes some hundred megabytes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConvertOutcome:
    """What was written.

    Parameters
    ----------
    document
        The same as JSON has it: ``files`` has one object for each file that was converted.
    findings
        What could not be kept or read; equal sentences are one finding for all of their files.

    """

    document: Mapping[str, object]
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Done:
    said: Mapping[str, object] | None
    findings: tuple[Finding, ...]


def convert(
    paths: Sequence[Path],
    out: Path,
    *,
    options: Options,
    conversion: Conversion,
    kind: FileKind | None = None,
    progress: Progress | None = None,
) -> ConvertOutcome:
    """Convert raw files.

    Parameters
    ----------
    paths
        Raw files, and folders whose raw files are taken at any depth.
    out
        A file ending in .dng, .tif or .tiff for one source, else a folder, which may exist.
    options
        Facts that outrank the files' own, and workers.
    conversion
        What becomes of the codes.
    kind
        What to write; None takes the ending of ``out``, and DNG in a folder.
    progress
        Told of every file.

    Raises
    ------
    UsageError
        Where nothing can be converted, or a file would be replaced that must not be; nothing was written then.

    """
    plan = planned(paths, out, kind=kind)
    places = {str(source): target for source, target in plan.targets}
    scenes, excluded = read_scenes([source for source, _target in plan.targets], options.selection)
    refused = [
        Finding(code=one.code, severity=Severity.ERROR, message=_sentence(one.reason), files=(one.name,))
        for one in excluded
    ]
    targets = [frame_target(places[str(scene.path)], scene.frame) for scene in scenes]
    require_free(plan, targets, overwrite=conversion.overwrite)
    if progress is not None:
        progress.start(len(scenes))

    def work(planned_frame: tuple[Scene, Path]) -> _Done:
        scene, target = planned_frame
        done = _attempt(scene, target, conversion, kind=plan.kind)
        if progress is not None:
            progress.advance()
        return done

    outcomes = in_threads(work, zip(scenes, targets, strict=True), workers=min(options.workers, _MOST_AT_ONCE))
    findings = _merged((*refused, *(one for done in outcomes for one in done.findings)))
    said = [done.said for done in outcomes if done.said is not None]
    if not said:
        reasons = [f"{', '.join(one.files)}: {one.message}" for one in findings if one.severity is Severity.ERROR]
        raise UsageError("Nothing was converted.\n  " + "\n  ".join(reasons))
    document = {"schema": SCHEMA, "files": said, "findings": [asdict(one) for one in findings]}
    return ConvertOutcome(document=document, findings=findings)


def _attempt(scene: Scene, target: Path, conversion: Conversion, *, kind: FileKind) -> _Done:
    """Convert one file; what is wrong with it becomes a finding."""
    try:
        done = recoded(scene, conversion, kind=kind)
        with fullness_named(target):
            written = write_converted(scene, done, target, conversion=conversion, kind=kind)
    except RawFileError as error:
        files = (str(scene.path),)
        refusal = Finding(code=error.code, severity=Severity.ERROR, message=_sentence(error.message), files=files)
        return _Done(said=None, findings=(refusal,))
    told = tuple(replace(one, files=(str(scene.path),)) for one in scene.findings)
    findings = (*told, *conversion_findings(scene, done, conversion, kind=kind))
    return _Done(said=_said(scene, done, written, kind=kind), findings=findings)


def _said(scene: Scene, done: Recoded, written: Sequence[Path], *, kind: FileKind) -> Mapping[str, object]:
    header, codes, black = scene.header, done.codes, written_black(scene, done)
    height, width = codes.mosaic.shape
    picture = done.rgb is not None
    return {
        "path": f"{scene.path}{scene.frame}",
        "out": str(written[0]),
        "sidecar": str(written[1]) if len(written) > 1 else None,
        "format": kind,
        "picture": picture,
        "width": header.width,
        "height": header.height,
        "raw_width": width,
        "raw_height": height,
        "cfa": None if picture else scene.cfa,
        "bit_depth": codes.bit_depth,
        "black_level": None if black is None else list(black),
        "white_level": min(codes.white_level),
        "iso": header.iso,
        "exposure_s": header.exposure_s,
        "codes_shifted_out": done.shifted_out,
        "clipped_below_black": done.clipped and done.clipped.below,
        "clipped_above_white": done.clipped and done.clipped.above,
    }


def _merged(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings with those that say the same about several files made one, the worst first."""
    files: dict[Finding, list[str]] = {}
    for one in findings:
        files.setdefault(replace(one, files=()), []).extend(one.files)
    merged = [replace(one, files=tuple(dict.fromkeys(names))) for one, names in files.items()]
    return tuple(sorted(merged, key=lambda one: one.severity.rank))


def _sentence(text: str) -> str:
    """Return a reason as a sentence."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."
